#pragma once
#include <functional>
#include <vector>

#include "engine/tree/nodes.hpp"

namespace hoodoo::tree {

/// A construction tree: a node and what stands below it, in the order of its slots.
///
///     Node cave{Sphere{...}};
///     Node both{Union{}, {cave, other}};
struct Node {
  AnyNode value;
  std::vector<Node> children{};
  friend bool operator==(const Node&, const Node&) = default;
};

/// Calls `change` for every Point of the tree, in a fixed order (to turn ground points into fixed
/// ones).
void for_each_point(Node& tree, const std::function<void(Point&)>& change);

/// Calls `change` for every list of balls of the tree, in a fixed order.
void for_each_balls(Node& tree, const std::function<void(Balls&)>& change);

/// What is known of the whole tree: where it is not 0, its range, its Lipschitz bound. Points are
/// fixed.
Support support(const Node& tree);

/// The tree as far as it matters inside `reach` [m]: what misses it, or is thinner than `thinnest`
/// [m], is replaced by nothing or by 0 (an empty blend). Inside `reach` the pruned tree has the
/// same bits, but for what was too thin.
Node prune(const Node& tree, const Box& reach, double thinnest);

/// Calls `visit` for each of its children in their order, also where it holds them packed.
void for_each_child(const Node& tree, const std::function<void(const Node&)>& visit);

/// How many nodes the tree has; a list of balls counts as so many nodes more.
std::size_t count(const Node& tree);
/// Bytes it takes, voxels and balls in files apart.
std::size_t memory(const Node& tree);

}  // namespace hoodoo::tree
