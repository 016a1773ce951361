#pragma once
#include <cmath>

#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Many balls under one sum, with one roughness. `N::stretch` times a ball's radius plus
/// `N::margin` is how far its field reaches [m].
struct BallSet {
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Balls balls;
  StarTurbulence turbulence;
  friend bool operator==(const BallSet&, const BallSet&) = default;
};

template <class N>
constexpr auto ball_set_fields() {
  return std::tuple{
      BallList<N>{"balls", &N::balls, 1, most_balls,
                  "Each [x, y, z, radius] or [x, y, z, radius, energy]; the energy is 1 else."},
      Group<N, StarTurbulence>{"turbulence", &N::turbulence, "Roughness of the boundaries."}};
}

/// That of a blend of them.
template <class N>
Support ball_set_support(const N& node) {
  Support all{Box(), {0, 0}, 0};
  if (node.balls.empty()) return all;
  all.influence = node.balls.box(node.stretch() * (1 + 5e-5)).grown(node.margin() * (1 + 5e-5));
  double steepest = 0;
  for (const Balls::Stored& b : node.balls.stored()) {
    const auto energy = static_cast<double>(b.energy);
    all.range = all.range + zero_to(energy);
    steepest += std::abs(energy) * steepest_falloff / node.reach(b.radius);
  }
  all.slope = node.turbulence.amplitude > 0 ? Support::no_bound : steepest;
  return all;
}

}  // namespace hoodoo::tree
