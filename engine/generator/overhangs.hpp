#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/generator/growth.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/skeleton.hpp"

namespace hoodoo::generator {

/// Undercuts along cliffs and the sides of valleys. Middles are Poisson-sphere samples of the
/// surface where it is steep. From each a line follows the face at one height, both ways; a lens is
/// cut into the rock along it, as deep at each place as the effect e there: the stress is how open
/// the input terrain lies, so that hard rock stays between soft. The floor is level, the roof rises
/// towards the mouth.
///
/// Reach: an undercut is a function of the surface within its length of its middle; the region
/// holds the middles, and weighs the depth at each place.
/// Source: Paris et al. 2019, sections 6.1 and 8.2.
struct Overhangs {
  static constexpr std::string_view type = "overhangs";
  static constexpr std::string_view doc =
      "Undercuts along cliffs and the sides of valleys: lenses that follow the face, as deep as "
      "the rock is weak and the ground before it open.";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 6.1 and 8.2";

  double distance = 25;  // [m]
  double length = 30;    // [m]
  double height = 6;     // [m]
  double depth = 6;      // [m]
  double variation = 0.3;
  double steepness = 45;  // [deg]
  double openness = 10;   // [m]
  double roof = 0;
  double beta = 0.1;
  double threshold = 0.15;
  tree::StarTurbulence turbulence;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = Overhangs;
    using namespace tree;
    return std::tuple{
        Number<T>{"distance", &T::distance, "m", above(0, longest), 25.0,
                  "Least distance between the middles of two."},
        Number<T>{"length", &T::length, "m", above(0, 10'000), 30.0,
                  "Along the face, where it goes on so far."},
        Number<T>{"height", &T::height, "m", above(0, longest), 6.0, "From the floor to the roof."},
        Number<T>{"depth", &T::depth, "m", above(0, longest), 6.0,
                  "How far they go in where the effect is 1; at most 50 times the height."},
        Number<T>{"variation", &T::variation, "1", within(0, 0.95), 0.3,
                  "Sizes differ from one to the other by up to this share."},
        Number<T>{"steepness", &T::steepness, "deg", within(0, 90), 45.0,
                  "Ground that is less steep has none."},
        Number<T>{"openness", &T::openness, "m", above(0, 1000), 10.0,
                  "Radius of the ball that must fit in front of a place for the stress to be 1."},
        Number<T>{"roof", &T::roof, "1", within(0, 1), 0.0,
                  "Least resistance of the rock a height above the middle, which must hold the "
                  "roof."},
        Number<T>{"beta", &T::beta, "1", within(0, 1), 0.1,
                  "Effect on the hardest rock where the stress is greatest: e = s (1 - rho)(1 - "
                  "beta) + s beta."},
        Number<T>{"threshold", &T::threshold, "1", within(0, 1), 0.15,
                  "Middles of a smaller effect are left out."},
        Group<T, StarTurbulence>{"turbulence", &T::turbulence, "Roughness of the walls."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u, "Of places and sizes."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
