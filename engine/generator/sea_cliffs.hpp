#pragma once
#include <string_view>

#include "engine/generator/erosion.hpp"

namespace hoodoo::generator {

/// The sea at work on a coast: each step samples the surface so far around sea level and carves
/// balls where it is steep, open to the sea and soft, so that notches, caves and arches grow where
/// the rock is weak. sigma = w alpha: w = (1 - (|z - sea_level| / range)^2)^3, alpha the radius of
/// the largest ball that touches the input terrain there from outside, over `openness`.
/// Source: Paris et al. 2019, section 6.1; alpha: Miller 1994.
struct SeaCliffs : Erosion {
  static constexpr std::string_view type = "sea_cliffs";
  static constexpr std::string_view doc =
      "The sea at work on a coast: notches, caves and arches grow around sea level where the rock "
      "is weak, step by step.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 6.1; Miller 1994";

  double sea_level = 0;   // [m]
  double range = 12;      // [m]
  double openness = 10;   // [m]
  double steepness = 30;  // [deg]
  int steps = 1;

  static constexpr auto fields() {
    using T = SeaCliffs;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{
            Number<T>{"sea_level", &T::sea_level, "m", within(-farthest, farthest), 0.0,
                      "Elevation of the sea."},
            Number<T>{"range", &T::range, "m", above(0, longest), 12.0,
                      "How far above and below sea level the waves work; their stress falls "
                      "to 0 there."},
            Number<T>{"openness", &T::openness, "m", above(0, 1000), 10.0,
                      "Radius of the ball that must fit in front of a place for the waves to "
                      "have their whole strength there."},
            Number<T>{"steepness", &T::steepness, "deg", within(0, 90), 30.0,
                      "Ground that is less steep is beach, and is left alone."},
            Whole<T>{"steps", &T::steps, 1, 20, 1,
                     "How often the sea works; each time on what the last left."}},
        erosion_fields<T>());
  }
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
