#include "engine/scene/brushes/cave.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::scene {
namespace {

/// In [-1, 1], by place along the passage and axis.
double stray(std::uint32_t seed, int bend, int axis) {
  return 2 * unit_real(random_bits(seed, bend, axis)) - 1;
}

}  // namespace

void CaveBrush::check(const std::string& where, std::vector<Problem>& problems) const {
  check_tube(std::min(radius, chamber_radius.value_or(radius)), turbulence, where, problems);
}

tree::Node CaveBrush::build() const {
  const Vec3 inward = normalized(direction);
  const Vec3 across = normalized(cross(inward, {0, 0, 1}), {1, 0, 0});
  const Vec3 over = cross(across, inward);
  const double chamber = chamber_radius.value_or(1.5 * radius);

  // The passage starts a radius before the mouth, which therefore opens to the air even in a wall
  // that the entrance was not placed exactly on, and bends once in three radii.
  const int bends = static_cast<int>(std::clamp(depth / (3 * radius), 1.0, 256.0));
  std::vector<Vec3> axis = {entrance.value - inward * radius, entrance.value};
  for (int i = 1; i <= bends; ++i) {
    const double off = i < bends ? winding * radius : 0;
    axis.push_back(entrance.value + inward * (depth * i / bends) +
                   across * (off * stray(seed, i, 0)) + over * (0.5 * off * stray(seed, i, 1)));
  }
  tree::PointNode hall;
  hall.center = axis.back();
  hall.radius = chamber;
  hall.turbulence = turbulence;
  return {tree::Union{}, {tube(smooth_curve(axis, radius), radius, turbulence), {hall, {}}}};
}

}  // namespace hoodoo::scene
