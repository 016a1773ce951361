#include "engine/tree/pack.hpp"

#include <utility>
#include <variant>

namespace hoodoo::tree {
namespace {

constexpr std::size_t fewest = 8;  // fewer are not worth an index of their own
constexpr std::size_t fewest_packed = 64;

/// One child among others of its kind, as the ball it is.
template <class N>
Ball ball_of(const N& node) {
  return {node.center.value, node.radius, static_cast<float>(node.energy)};
}

bool alike(const PointNode& a, const PointNode& b) { return a.turbulence == b.turbulence; }
bool alike(const Sphere& a, const Sphere& b) {
  return a.turbulence == b.turbulence && a.falloff == b.falloff;
}

PointSet set_of(const PointNode& like, const std::vector<Ball>& balls) {
  PointSet set;
  set.balls = Balls(balls);
  set.turbulence = like.turbulence;
  return set;
}
SphereSet set_of(const Sphere& like, const std::vector<Ball>& balls) {
  SphereSet set;
  set.balls = Balls(balls);
  set.turbulence = like.turbulence;
  set.falloff = like.falloff;
  return set;
}

/// Where the run of children like the one at `from` ends.
template <class N>
std::size_t end_of_run(const std::vector<Node>& children, std::size_t from) {
  const N& first = std::get<N>(children[from].value);
  std::size_t end = from + 1;
  for (; end < children.size(); ++end) {
    const N* next = std::get_if<N>(&children[end].value);
    if (next == nullptr || !alike(first, *next)) break;
  }
  return end;
}

/// Moves the run that begins at `from`, as one node if it is long; returns where it ends.
template <class N>
std::size_t move_run(std::vector<Node>& children, std::size_t from, std::vector<Node>& packed) {
  const std::size_t end = end_of_run<N>(children, from);
  if (end - from < fewest) {
    for (std::size_t i = from; i < end; ++i) packed.push_back(std::move(children[i]));
    return end;
  }
  std::vector<Ball> balls;
  balls.reserve(end - from);
  for (std::size_t i = from; i < end; ++i) {
    balls.push_back(ball_of(std::get<N>(children[i].value)));
  }
  packed.push_back({set_of(std::get<N>(children[from].value), balls), {}});
  return end;
}

std::vector<Node> packed_terms(std::vector<Node> children) {
  std::vector<Node> packed;
  for (std::size_t i = 0; i < children.size();) {
    if (std::holds_alternative<PointNode>(children[i].value)) {
      i = move_run<PointNode>(children, i, packed);
    } else if (std::holds_alternative<Sphere>(children[i].value)) {
      i = move_run<Sphere>(children, i, packed);
    } else {
      packed.push_back(std::move(children[i++]));
    }
  }
  packed.shrink_to_fit();
  return packed;
}

void pack_union(Node& tree) {
  auto* all = std::get_if<Union>(&tree.value);
  if (all == nullptr || tree.children.size() < fewest_packed) return;
  if (auto packed = PackedTrees::of(tree.children)) {
    all->packed = *std::move(packed);
    tree.children = {};
  }
}

}  // namespace

Node pack(Node tree) {
  for (Node& child : tree.children) child = pack(std::move(child));
  pack_union(tree);
  if (!std::holds_alternative<Blend>(tree.value)) return tree;
  const std::size_t before = tree.children.size();
  tree.children = packed_terms(std::move(tree.children));
  const bool sum_alone = tree.children.size() == 1 && before > 1;
  if (sum_alone && std::get<Blend>(tree.value).energy == 1) return std::move(tree.children[0]);
  return tree;
}

Node pack_unions(Node tree) {
  for (Node& child : tree.children) child = pack_unions(std::move(child));
  pack_union(tree);
  return tree;
}

}  // namespace hoodoo::tree
