#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/box.hpp"

namespace hoodoo::tree {

struct Node;     // node.hpp
struct Support;  // node_type.hpp

/// An immutable list of trees that is asked by place; copies share it. Holds of each node what
/// differs from a new one of its type, and a box of 24 bytes around each tree: a rough sphere takes
/// 62 bytes, where a Node takes over 200.
class PackedTrees {
 public:
  PackedTrees() = default;
  /// None where a tree holds what has no packed form: texts, lists, voxels, balls. Points are
  /// fixed.
  static std::optional<PackedTrees> of(const std::vector<Node>& trees);

  std::size_t size() const;
  bool empty() const { return size() == 0; }
  /// The bits that were packed.
  Node tree(std::size_t index) const;
  /// Whether the tree may matter inside `reach`: where not, it compiles and prunes to nothing.
  bool reaches(std::size_t index, const Box& reach) const;
  /// Of their union.
  Support support() const;
  /// Nodes in all trees.
  std::size_t count() const;
  /// Bytes they take.
  std::size_t memory() const;

  friend bool operator==(const PackedTrees& a, const PackedTrees& b);

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace hoodoo::tree
