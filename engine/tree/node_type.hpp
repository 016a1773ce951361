#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/points.hpp"

namespace hoodoo::tree {

/// Which trees a node may stand in: the terrain field F, the geology rho, or both; or those whose
/// value is a distance (distance.hpp).
enum class Family { terrain, geology, any, distance };

/// Where a node keeps others. Its children stand in the order of its slots.
struct Slot {
  std::string_view key;
  std::string_view doc;
  std::size_t least, most;      // how many
  bool list;                    // JSON: an array; else one object
  Family family = Family::any;  // of what it holds; any: that of the tree the node stands in
};
inline constexpr std::size_t any_number = 10'000'000;

/// What is known of a tree's value without evaluating it.
struct Support {
  Box influence;     // the value is exactly 0 outside [m]
  Interval range;    // contains every value
  double slope = 0;  // Lipschitz bound [1/m]; infinity where there is none

  static constexpr double no_bound = std::numeric_limits<double>::infinity();
};

/// From 0 to a peak, which evaluation holds in single precision.
inline Interval zero_to(double peak) {
  const double p = static_cast<double>(static_cast<float>(peak));
  return {std::min(0.0, p), std::max(0.0, p)};
}

/// A block of space: points relative to `origin`, in single precision, lying in `box` [m]. Both in
/// the coordinates of the tree that is evaluated there.
struct Block {
  Vec3 origin;
  Box box;
};

/// What a type must offer to be a node. Parsing, schema, canonical JSON and the conformance suite
/// are derived from these names; evaluation from one of the kinds below.
template <class N>
concept NodeType = std::default_initializable<N> && std::equality_comparable<N> &&
    requires(const N node, std::span<const Support> children) {
  { N::type } -> std::convertible_to<std::string_view>;  // JSON "type"
  { N::doc } -> std::convertible_to<std::string_view>;
  { N::cited } -> std::convertible_to<std::string_view>;  // where the formula is from
  { N::family } -> std::convertible_to<Family>;
  N::fields();                                          // tuple of descriptors (fields.hpp)
  {std::span<const Slot>(N::slots)};                    // array of Slot
  { node.support(children) } -> std::same_as<Support>;  // influence, range, Lipschitz bound
};

/// No children.
inline constexpr std::array<Slot, 0> no_slots{};

/// The place of a point relative to a skeletal primitive. T is float, double, or a Dual of them.
template <class T>
struct Projection {
  T distance;  // [m]; thin: to the skeleton; volume: signed, to the boundary, negative inside
  T x, y, z;   // the point's projection on the unperturbed boundary, relative to the block
};

/// A skeleton without volume; its field falls off from the skeleton itself.
/// `shape<S>(origin)` gives its geometry relative to `origin` in numbers S, with
/// `Projection<T> project(T x, T y, T z)` and T `distance_squared(T x, T y, T z)`.
template <class N>
concept ThinPrimitive = requires(const N node, const Vec3& origin) {
  node.template shape<float>(origin);
  { node.radius } -> std::convertible_to<double>;
  requires N::thin;
};

/// A solid whose field is constant inside and falls off from its boundary.
template <class N>
concept VolumePrimitive = requires(const N node, const Vec3& origin) {
  node.template shape<float>(origin);
  { node.half_thickness() } -> std::convertible_to<double>;
  requires !N::thin;
};

template <class N>
concept Primitive = ThinPrimitive<N> || VolumePrimitive<N>;

/// Joins its children's values pointwise: `first(v0)`, then `join(value, v_i)` in their order, then
/// `last(value)`, each for T = float, Dual<float> and Interval.
template <class N>
concept Combiner = requires(const N node, float v) {
  { node.first(v) } -> std::same_as<float>;
  { node.join(v, v) } -> std::same_as<float>;
  { node.last(v) } -> std::same_as<float>;
};

/// A linear map of coordinates relative to an origin: rows of a 3 x 3 matrix.
using Matrix = std::array<std::array<double, 3>, 3>;

/// Evaluates its one child elsewhere, at an affine map of the point whose linear part is `inward`.
template <class N>
concept Transform = requires(const N node, const Vec3& p) {
  { node.inward() } -> std::same_as<Matrix>;
  { node.to_child(p) } -> std::same_as<Vec3>;
  { node.from_child(p) } -> std::same_as<Vec3>;
  { node.shrink() } -> std::same_as<double>;  // a thickness t of the child is at least t times this
};

/// A transform that keeps distances, so that it may stand in a distance tree.
template <class N>
concept RigidTransform = Transform<N> && requires {
  requires N::rigid;
};

/// Evaluates its first child at p + fD(p) delta(p), fD its second child clamped to [0,1] (1 where
/// there is none), |delta_i| <= reach().
template <class N>
concept Displacement = requires(const N node, const Vec3& origin, const Points& at,
                                std::span<float> v, const Gradients& g) {
  { node.reach() } -> std::same_as<double>;
  // Of delta_axis at the points no farther from a place than a distance [m].
  { node.displacement_bounds(0, origin, 1.0) } -> std::same_as<Interval>;
  node.displacement(0, origin, at, v);              // delta_axis
  node.displacement_gradient(0, origin, at, v, g);  // and its gradient; the same bits
};

/// A leaf that sums many balls (ball_set.hpp).
template <class N>
concept Swarm = requires(const N node) {
  requires std::same_as<decltype(node.balls), Balls>;
  { N::thin } -> std::convertible_to<bool>;
  { node.stretch() } -> std::same_as<double>;  // a ball reaches stretch * radius + margin [m]
  { node.margin() } -> std::same_as<double>;
  { node.reach(1.0) } -> std::same_as<double>;  // R [m] of a ball of that radius
};

/// A leaf that is evaluated batch by batch.
template <class N>
concept Pattern = requires(const N node, const Vec3& origin, const Points& at, std::span<float> v,
                           const Gradients& g, const Block& block) {
  node.values(origin, at, v);
  node.gradients(origin, at, v, g);  // the same bits in v
  { node.bounds(block) } -> std::same_as<Interval>;
};

struct Node;      // node.hpp
struct Compiled;  // evaluate.hpp

/// What fits none of the kinds above: compiles and prunes itself, as tree::compile and tree::prune
/// promise.
///
///     Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
///     Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
template <class N>
concept Composite = requires {
  &N::compile_node;
  &N::prune_node;
};

}  // namespace hoodoo::tree
