#pragma once
#include <cstdint>
#include <string_view>
#include <tuple>

#include "engine/generator/bands.hpp"
#include "engine/generator/growth.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// The erosion operator on steep slopes alone: F - a fD (1 - rho), rho the geology with finer bands
/// added, so that soft layers retreat and hard ones stand out as ledges. fD is a sum of balls at
/// Poisson-sphere samples of the surface where it is steeper than `steepness`, in such shares that
/// at each sample the softest rock loses `depth` along the normal.
///
/// F tells depths only as far as it falls off around a surface, so that a face loses no more than
/// 0.9 of that: terrains of a larger falloff can be worn more deeply.
///
/// Reach: a ball depends on the samples in reach of it and weighs as its place in the region.
/// Source: Paris et al. 2019, section 5.3 and figure 10.
struct CliffStrata {
  static constexpr std::string_view type = "cliff_strata";
  static constexpr std::string_view doc =
      "Ledges on cliffs: differential erosion by the geology and finer bands, where the surface is "
      "steep and nowhere else.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.3 and figure 10";

  double depth = 3;       // [m]
  double steepness = 50;  // [deg]
  double falloff = 10;    // [deg]
  double distance = 3;    // [m]
  Bands bands;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = CliffStrata;
    using namespace tree;
    return std::tuple{
        Number<T>{"depth", &T::depth, "m", above(0, 1000), 3.0,
                  "What the softest rock loses, along the normal; at most 0.9 of the way along "
                  "which F reaches 1."},
        Number<T>{"steepness", &T::steepness, "deg", within(0, 90), 50.0,
                  "Slopes that are less steep are left alone."},
        Number<T>{"falloff", &T::falloff, "deg", within(0, 90), 10.0,
                  "How much steeper a slope must be to lose the whole depth."},
        Number<T>{"distance", &T::distance, "m", above(0, longest), 3.0,
                  "Least distance between two samples of the surface."},
        Group<T, Bands>{"bands", &T::bands, "Layers that are added to the geology."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u, "Of samples and bands."}};
  }
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
