#pragma once
#include <string_view>

#include "engine/generator/erosion.hpp"

namespace hoodoo::generator {

/// A river at work on its banks: balls are carved where the stream is strong and the rock soft,
/// deeper into the outer banks of bends, which then overhang. The stress is the stream power
/// A^(1/2) s of the input terrains, over its `percentile`, where that is greater than `stress` and
/// the area at least `drainage`; from there it falls off across `banks` in plan (a convolution) and
/// `flood` in height. Source: Paris et al. 2019, section 6.1; drainage area: Freeman 1991 on
/// elevations filled as Barnes et al. 2014. Outer banks: the stress of a bed cell is greater away
/// from the centroid of the bed around it, which lies inside the bend.
struct RiverCanyon : Erosion {
  static constexpr std::string_view type = "river_canyon";
  static constexpr std::string_view doc =
      "Rivers at work on their banks: the stream's power hollows soft rock out, most of all on the "
      "outer banks of bends.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 6.1; Freeman 1991";

  double percentile = 99.5;
  double stress = 0.4;
  double drainage = 0;  // [m^2]
  double banks = 12;    // [m]
  double flood = 10;    // [m]
  double outer = 0.7;
  double steepness = 25;  // [deg]
  double pixel = 0;       // [m]
  int steps = 1;

  static constexpr auto fields() {
    using T = RiverCanyon;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{
            Number<T>{"percentile", &T::percentile, "%", above(0, 100), 99.5,
                      "The stream power of which this share of the terrain has less counts as a "
                      "stress of 1."},
            Number<T>{"stress", &T::stress, "1", within(0, 1), 0.4,
                      "The bed of a river is where the stress is greater."},
            Number<T>{"drainage", &T::drainage, "m^2", within(0, 1e15), 0.0,
                      "A river drains at least this area."},
            Number<T>{"banks", &T::banks, "m", above(0, 1000), 12.0,
                      "How far from the bed the river works on its banks."},
            Number<T>{"flood", &T::flood, "m", above(0, longest), 10.0,
                      "How far above the bed; the stress falls to 0 there."},
            Number<T>{"outer", &T::outer, "1", within(0, 1), 0.7,
                      "How much more it works on the outer banks of bends, and less on the inner "
                      "ones."},
            Number<T>{"steepness", &T::steepness, "deg", within(0, 90), 25.0,
                      "Ground that is less steep is the bed, and is left alone."},
            Number<T>{"pixel", &T::pixel, "m", within(0, longest), 0.0,
                      "Cell size at which the water's way is found; 0 is that of the terrains."},
            Whole<T>{"steps", &T::steps, 1, 20, 1,
                     "How often the river works; each time on what the last left."}},
        erosion_fields<T>());
  }
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
