#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/generator/bands.hpp"
#include "engine/generator/growth.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// Islands in the air: two height fields, one of them upside down, cut to a ragged outline. Their
/// middles are Poisson-disk samples of the plane. The erosion operator wears them by the geology at
/// their place and finer bands; then invasion percolation carves caves into the softer rock, from
/// places on their undersides.
///
/// Reach: an island is a function of its sample and of the ground under it; the region holds the
/// middles. One that would cross the world's edge is left out.
/// Source: Paris et al. 2019, sections 5.1, 5.3 and 6.2, figure 20.
struct FloatingIslands {
  static constexpr std::string_view type = "floating_islands";
  static constexpr std::string_view doc =
      "Islands in the air: two height fields, one upside down, with strata and caves.";
  static constexpr std::string_view cited =
      "Paris et al. 2019, sections 5.1, 5.3 and 6.2, figure 20";

  std::optional<double> distance;               // [m]
  double least_radius = 60, most_radius = 120;  // [m]
  double least_height = 80, most_height = 200;  // [m]
  double relief = 0.25, rim = 0.12, depth = 1;  // [radii]
  double probability = 1;
  double erosion = 4;  // [m]
  Bands bands;
  int caves = 2;
  double cave_radius = 5;  // [m]
  std::uint32_t cave_length = 120;
  double rho_0 = 0.6;
  std::uint32_t seed = 0;

  static constexpr auto place_fields() {
    using T = FloatingIslands;
    using namespace tree;
    return std::tuple{
        OptionalNumber<T>{"distance", &T::distance, "m", above(0, longest),
                          "Least distance between two middles; by default 2.2 times the largest "
                          "radius."},
        Number<T>{"least_radius", &T::least_radius, "m", above(0, 10'000), 60.0,
                  "Of the circle that holds the smallest."},
        Number<T>{"most_radius", &T::most_radius, "m", above(0, 10'000), 120.0,
                  "Of the circle that holds the largest."},
        Number<T>{"least_height", &T::least_height, "m", within(0, longest), 80.0,
                  "Least air between the highest ground under an island and its lowest rock."},
        Number<T>{"most_height", &T::most_height, "m", within(0, longest), 200.0,
                  "The most of it."},
        Number<T>{"probability", &T::probability, "1", within(0, 1), 1.0,
                  "Share of the places that have one."}};
  }
  static constexpr auto shape_fields() {
    using T = FloatingIslands;
    using namespace tree;
    return std::tuple{
        Number<T>{"relief", &T::relief, "radii", within(0, 10), 0.25, "Height of the hills."},
        Number<T>{"rim", &T::rim, "radii", within(0.01, 10), 0.12, "Thickness at the edge."},
        Number<T>{"depth", &T::depth, "radii", within(0, 10), 1.0,
                  "How much deeper the middle reaches, about."},
        Number<T>{"erosion", &T::erosion, "m", within(0, 1000), 4.0,
                  "What the softest rock loses, along the normal, about."},
        Group<T, Bands>{"bands", &T::bands, "Layers that are added to the geology."},
        Whole<T>{"caves", &T::caves, 0, 100, 2, "Places where caves begin, on each island."},
        Number<T>{"cave_radius", &T::cave_radius, "m", above(0, 1000), 5.0,
                  "Radius of the balls that are carved out along caves."},
        Whole<T, std::uint32_t>{"cave_length", &T::cave_length, 1, 100'000, 120u,
                                "Most balls from one place."},
        Number<T>{"rho_0", &T::rho_0, "1", within(0, 2), 0.6,
                  "Rock of this resistance and more has no caves."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u,
                                "Of places, sizes, shapes and caves."}};
  }
  static constexpr auto fields() { return std::tuple_cat(place_fields(), shape_fields()); }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  void grow(Growth& growth) const;
};

}  // namespace hoodoo::generator
