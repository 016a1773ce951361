#include "engine/tree/node.hpp"

#include <cassert>
#include <cmath>
#include <tuple>
#include <type_traits>
#include <variant>

#include "engine/tree/ball_kernel.hpp"
#include "engine/tree/composite.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {
namespace {

template <class N>
void change_point(N& node, const Position<N>& field, const std::function<void(Point&)>& change) {
  change(node.*field.member);
}
template <class N>
void change_point(N& node, const Positions<N>& field, const std::function<void(Point&)>& change) {
  for (Point& point : node.*field.member) change(point);
}
template <class N, class Field>
void change_point(N&, const Field&, const std::function<void(Point&)>&) {}
template <class N, class G>
void change_point(N& node, const Groups<N, G>& field, const std::function<void(Point&)>& change) {
  for (G& one : node.*field.member) {
    std::apply([&](const auto&... f) { (change_point(one, f, change), ...); }, G::fields());
  }
}

template <class N>
concept MayBePacked = requires(const N node) {
  node.packed;
};

/// A point that no block inside `reach` is farther from than it is wide.
Vec3 corner_of(const Box& reach) {
  Vec3 corner = reach.min;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(corner[axis])) corner[axis] = 0;
  }
  return corner;
}

template <class N>
double thickness(const N& node) {
  if constexpr (N::thin) {
    return 2 * node.radius;
  } else {
    return 2 * node.half_thickness();
  }
}

struct Pruner {
  const std::vector<Node>& children;
  const Box& reach;
  double thinnest;

  template <Primitive N>
  Node operator()(const N& node) const {
    const bool keep = thickness(node) >= thinnest && reaches(node.support({}).influence, reach);
    return keep ? Node{node, {}} : nothing();
  }
  template <Combiner N>
  Node operator()(const N& node) const {
    Node pruned{node, {}};
    bool any = false, zero = false;
    if constexpr (requires { node.of_zero(); }) any = node.of_zero() != 0;
    const auto add = [&](std::size_t i, Node child) {
      const bool empty = is_nothing(child);
      any = any || !empty;
      // As combine_kernel.hpp: a child that is 0 changes nothing in a sum, nor after another.
      if (empty && i > 0 && (zero || N::adds)) return;
      zero = zero || empty;
      pruned.children.push_back(std::move(child));
    };
    if constexpr (MayBePacked<N>) {
      pruned.value = N();
      for (std::size_t i = 0; i < node.packed.size(); ++i) {
        const bool near = node.packed.reaches(i, reach);
        add(i, near ? prune(node.packed.tree(i), reach, thinnest) : nothing());
      }
    }
    for (std::size_t i = 0; i < children.size(); ++i) add(i, prune(children[i], reach, thinnest));
    return any ? pruned : nothing();
  }
  template <Transform N>
  Node operator()(const N& node) const {
    const Box inner = mapped(reach, [&](const Vec3& p) { return node.to_child(p); });
    Node child = prune(children[0], inner, thinnest / node.shrink());
    return is_nothing(child) ? child : Node{node, {std::move(child)}};
  }
  template <Displacement N>
  Node operator()(const N& node) const {
    Node control = nothing();
    if (children.size() > 1) {
      control = prune(children[1], reach, 0);
      if (is_nothing(control)) return prune(children[0], reach, thinnest);
    }
    Node child = prune(children[0], reach.grown(node.reach()), thinnest);
    if (is_nothing(child)) return child;
    Node pruned{node, {std::move(child)}};
    if (children.size() > 1) pruned.children.push_back(std::move(control));
    return pruned;
  }
  template <Composite N>
  Node operator()(const N& node) const {
    return node.prune_node(children, reach, thinnest);
  }
  template <Swarm N>
  Node operator()(const N& node) const {
    const double least = thinnest / 2;
    std::vector<Ball> kept;
    const N held = held_near(node, reach, corner_of(reach), least);
    for (const auto& found : balls_near(held, reach, corner_of(reach))) {
      if (found.ball->radius >= least) kept.push_back(found.ball->ball());
    }
    if (kept.empty()) return nothing();
    N pruned = held;
    if (kept.size() < held.balls.size()) pruned.balls = Balls(kept);
    return {std::move(pruned), {}};
  }
  template <Pattern N>
  Node operator()(const N& node) const {
    return {node, {}};
  }
};

}  // namespace

void for_each_point(Node& tree, const std::function<void(Point&)>& change) {
  std::visit(
      [&](auto& node) {
        using N = std::remove_reference_t<decltype(node)>;
        if constexpr (MayBePacked<N>) assert(node.packed.empty());
        std::apply([&](const auto&... f) { (change_point(node, f, change), ...); }, N::fields());
      },
      tree.value);
  for (Node& child : tree.children) for_each_point(child, change);
}

void for_each_balls(Node& tree, const std::function<void(Balls&)>& change) {
  std::visit(
      [&](auto& node) {
        if constexpr (requires { node.balls.size(); }) change(node.balls);
      },
      tree.value);
  for (Node& child : tree.children) for_each_balls(child, change);
}

Node nothing() { return {Blend{}, {}}; }
bool is_nothing(const Node& node) {
  return std::holds_alternative<Blend>(node.value) && node.children.empty();
}

bool reaches(const Box& influence, const Box& reach) {
  Box near = reach;  // what is at infinity does not round
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(near.min[axis])) near.min[axis] = influence.min[axis];
    if (std::isinf(near.max[axis])) near.max[axis] = influence.max[axis];
  }
  return influence.grown(2 * rounding(influence, {near.min, near})).overlaps(reach);
}

std::vector<Support> supports(const std::vector<Node>& trees) {
  std::vector<Support> all;
  all.reserve(trees.size());
  for (const Node& tree : trees) all.push_back(support(tree));
  return all;
}

Support support(const Node& tree) {
  return std::visit(
      [&](const auto& node) {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (std::is_same_v<N, FromDistance>) {
          const Support child = distance_support(tree.children[0]);
          return node.support({&child, 1});
        } else {
          if constexpr (MayBePacked<N>) {
            if (!node.packed.empty()) return node.packed.support();
          }
          return node.support(supports(tree.children));
        }
      },
      tree.value);
}

Node prune(const Node& tree, const Box& reach, double thinnest) {
  return std::visit(Pruner{tree.children, reach, thinnest}, tree.value);
}

void for_each_child(const Node& tree, const std::function<void(const Node&)>& visit) {
  if (const auto* all = std::get_if<Union>(&tree.value)) {
    for (std::size_t i = 0; i < all->packed.size(); ++i) visit(all->packed.tree(i));
  }
  for (const Node& child : tree.children) visit(child);
}

std::size_t count(const Node& tree) {
  std::size_t n = 1 + std::visit(
                          [](const auto& node) -> std::size_t {
                            if constexpr (requires { node.balls.size(); }) return node.balls.size();
                            if constexpr (requires { node.packed; }) return node.packed.count();
                            return 0;
                          },
                          tree.value);
  for (const Node& child : tree.children) n += count(child);
  return n;
}

std::size_t memory(const Node& tree) {
  constexpr std::size_t bytes_per_ball = 44;
  std::size_t bytes = sizeof(Node) + std::visit(
                                         [](const auto& node) -> std::size_t {
                                           if constexpr (requires { node.balls.in_file(); }) {
                                             if (!node.balls.in_file()) {
                                               return bytes_per_ball * node.balls.size();
                                             }
                                           }
                                           if constexpr (requires { node.packed; }) {
                                             return node.packed.memory();
                                           }
                                           return 0;
                                         },
                                         tree.value);
  for (const Node& child : tree.children) bytes += memory(child);
  return bytes;
}

}  // namespace hoodoo::tree
