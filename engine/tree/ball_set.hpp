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
  std::string file;  // of balls that whoever reads a scene fills in; it is "" from then on
  StarTurbulence turbulence;
  friend bool operator==(const BallSet&, const BallSet&) = default;
};

template <class N>
constexpr auto ball_set_fields() {
  return std::tuple{
      FileName<N>{"file", &N::file,
                  "Instead of `balls`, a CSV file relative to the scene file, as large as need be: "
                  "a first line x,y,z,radius or x,y,z,radius,energy, then a ball per line."},
      BallList<N>{"balls", &N::balls, 1, most_balls,
                  "Each [x, y, z, radius] or [x, y, z, radius, energy]; the energy is 1 else."},
      Group<N, StarTurbulence>{"turbulence", &N::turbulence, "Roughness of the boundaries."}};
}

/// Balls are listed, or in a file.
inline void check_source(const BallSet& set, const std::string& where,
                         std::vector<Problem>& problems) {
  if (set.balls.empty() && set.file.empty()) problems.push_back({where + "/balls", "is missing"});
  if (!set.balls.empty() && !set.file.empty()) {
    problems.push_back({where + "/file", "cannot stand beside \"balls\""});
  }
}

/// That of a blend of them.
template <class N>
Support ball_set_support(const N& node) {
  Support all{Box(), {0, 0}, 0};
  if (node.balls.empty()) return all;
  all.influence = node.balls.box(node.stretch() * (1 + 5e-5)).grown(node.margin() * (1 + 5e-5));
  double steepest = 0;
  node.balls.for_each([&](const Balls::Stored& b) {
    const auto energy = static_cast<double>(b.energy);
    all.range = all.range + zero_to(energy);
    steepest += std::abs(energy) * steepest_falloff / node.reach(b.radius);
  });
  all.slope = node.turbulence.amplitude > 0 ? Support::no_bound : steepest;
  return all;
}

}  // namespace hoodoo::tree
