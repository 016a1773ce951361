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

/// Openings through thin walls: fins, necks of headlands, promontories. From Poisson-sphere samples
/// of steep faces one looks level through the rock, straight in and up to 30 degrees to either
/// side; where air comes within `width`, there is a wall. It is a candidate with the probability
/// `probability` e(rho, s): rho of the rock in the middle, s = 1 - (thickness / width)^2. Of the
/// candidates nearer than `distance` to each other the one of the least hash is carved: between its
/// feet on the ground and the rock that must be left over it.
///
/// Reach: an arch is a function of the surface and of the candidates within `distance`; the region
/// holds the middles.
/// Source: Paris et al. 2019, sections 6.1 and 8.2.
struct Arches {
  static constexpr std::string_view type = "arches";
  static constexpr std::string_view doc =
      "Openings through thin walls of rock - fins, necks of headlands -, more of them where the "
      "wall is thin and the rock weak.";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 6.1 and 8.2";

  double width = 30;     // [m]
  double span = 12;      // [m]
  double height = 14;    // [m]
  double roof = 5;       // [m]
  double distance = 50;  // [m]
  double probability = 1;
  double variation = 0.3;
  double steepness = 45;  // [deg]
  double beta = 0.1;
  tree::StarTurbulence turbulence;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = Arches;
    using namespace tree;
    return std::tuple{
        Number<T>{"width", &T::width, "m", above(0, 10'000), 30.0,
                  "Thickness of the walls that are just too thick."},
        Number<T>{"span", &T::span, "m", above(0, 10'000), 12.0, "Width of an opening."},
        Number<T>{"height", &T::height, "m", above(0, 10'000), 14.0,
                  "Of an opening; less, down to half of it, under a low wall."},
        Number<T>{"roof", &T::roof, "m", above(0, 10'000), 5.0,
                  "Least thickness of the rock left over an opening."},
        Number<T>{"distance", &T::distance, "m", above(0, longest), 50.0,
                  "Least distance between the middles of two."},
        Number<T>{"probability", &T::probability, "1", within(0, 1), 1.0,
                  "Share of the places that are carved where the effect is 1."},
        Number<T>{"variation", &T::variation, "1", within(0, 0.95), 0.3,
                  "Sizes differ from one to the other by up to this share."},
        Number<T>{"steepness", &T::steepness, "deg", within(0, 90), 45.0,
                  "Faces that are less steep are not looked through."},
        Number<T>{"beta", &T::beta, "1", within(0, 1), 0.1,
                  "Effect on the hardest rock where the wall is thinnest: e = s (1 - rho)(1 - "
                  "beta) + s beta."},
        Group<T, StarTurbulence>{"turbulence", &T::turbulence, "Roughness of the walls."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u, "Of places and sizes."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
