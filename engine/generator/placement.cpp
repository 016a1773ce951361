#include "engine/generator/placement.hpp"

#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>

#include "engine/base/random.hpp"

namespace hoodoo::generator {
namespace {

using namespace tree;

template <class N, class... Of>
inline constexpr bool is_one_of = (std::is_same_v<N, Of> || ...);

/// Points and lengths without a direction, and what joins such.
template <class N>
inline constexpr bool turns_by_points =
    is_one_of<N, PointNode, Segment, Polyline, CatmullRom, Bezier, Sphere, Cone, TruncatedCone,
              Cylinder, Capsule, Blend, Carve, Union, Intersection, Difference, SmoothUnion,
              SmoothDifference>;
/// What has axes but a place by its points.
template <class N>
inline constexpr bool moves_by_points =
    turns_by_points<N> || is_one_of<N, BoxNode, RoundedBox, Ellipsoid, Torus>;

bool moves_by_its_points(const Node& node, bool turned) {
  const bool own = std::visit(
      [&]<class N>(const N&) { return turned ? turns_by_points<N> : moves_by_points<N>; },
      node.value);
  if (!own) return false;
  for (const auto& child : node.children) {
    if (!moves_by_its_points(child, turned)) return false;
  }
  return true;
}

void vary(Node& node, std::uint64_t seed) {
  const auto varied = [&](std::uint32_t own) {
    return static_cast<std::uint32_t>(random_bits(seed, own));
  };
  std::visit(
      [&](auto& n) {
        if constexpr (requires { n.seed; }) n.seed = varied(n.seed);
        if constexpr (requires { n.turbulence.seed; }) {
          n.turbulence.seed = varied(n.turbulence.seed);
        }
      },
      node.value);
  for (auto& child : node.children) vary(child, seed);
}

Vec3 turned(const Turn& turn, const Vec3& p) {
  Rotate rotate;
  rotate.axis = turn.axis;
  rotate.angle = turn.angle;
  return rotate.from_child(p);
}

}  // namespace

void Placement::turn(const Turn& further) {
  if (further.angle == 0) return;
  if (turns.empty() || !(turns.back().axis == further.axis)) {
    turns.push_back({further.axis, 0});
  }
  auto& angle = turns.back().angle;
  angle += further.angle;
  angle -= 360 * std::floor(angle / 360);
}

Vec3 Placement::of(const Vec3& p) const {
  Vec3 q = p * scale;
  for (auto turn = turns.rbegin(); turn != turns.rend(); ++turn) q = turned(*turn, q);
  return at + q;
}

Node placed(Node tree, const Placement& placement, std::uint64_t seed) {
  if (placement.scale == 1 && moves_by_its_points(tree, !placement.turns.empty())) {
    for_each_point(tree, [&](Point& p) { p = placement.of(p.value); });
    return tree;
  }
  vary(tree, seed);
  if (placement.scale != 1) {
    Scale scale;
    scale.by = {placement.scale, placement.scale, placement.scale};
    tree = {scale, {std::move(tree)}};
  }
  for (auto turn = placement.turns.rbegin(); turn != placement.turns.rend(); ++turn) {
    Rotate rotate;
    rotate.axis = turn->axis;
    rotate.angle = turn->angle;
    tree = {rotate, {std::move(tree)}};
  }
  Translate move;
  move.by = placement.at;
  return {move, {std::move(tree)}};
}

Node united(std::vector<Node> bodies) {
  if (bodies.size() == 1) return std::move(bodies.front());
  return {Union{}, std::move(bodies)};
}

}  // namespace hoodoo::generator
