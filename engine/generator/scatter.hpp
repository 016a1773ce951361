#pragma once
#include <array>
#include <optional>
#include <string_view>

#include "engine/generator/growth.hpp"
#include "engine/generator/habitat.hpp"
#include "engine/generator/stated_tree.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// Copies of a tree on the ground: boulders, scree, blocks. Places are Poisson-disk samples of the
/// plane, thinned to the density that is asked for where slope, drainage and altitude suit.
struct Scatter : Habitat {
  static constexpr std::string_view type = "scatter";
  static constexpr std::string_view doc =
      "Copies of a tree on the ground, turned and scaled at random, where slope and drainage suit "
      "them.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr std::array<std::string_view, 2> alignments = {"z", "normal"};
  static constexpr std::array<std::string_view, 3> joins = {"blend", "carve", "union"};
  enum class Align { upright, normal };

  Stated stated;                   // the tree as the scene has it
  double density = 0.01;           // [1/m^2]
  std::optional<double> distance;  // [m]
  double turn = 360;               // [deg]
  double tilt = 0;                 // [deg]
  double least_scale = 0.7, most_scale = 1.3;
  Align align = Align::upright;
  double sink = 0;  // [m]
  tree::Operation op = tree::Operation::unite;
  std::uint32_t seed = 0;

  tree::Node tree;  // of `stated`

  static auto fields() {
    using T = Scatter;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{
            Special<T, Stated>{"tree", &T::stated, tree_form, std::nullopt,
                               "What is copied, its origin on the ground."},
            Number<T>{"density", &T::density, "1/m^2", above(0, 1e4), 0.01,
                      "Copies per square metre where everything suits."},
            OptionalNumber<T>{"distance", &T::distance, "m", above(0, longest),
                              "Least distance between two; by default what makes a third of the "
                              "places empty."},
            Number<T>{"turn", &T::turn, "deg", within(0, 360), 360.0,
                      "They are turned about their own z by a random angle up to this."},
            Number<T>{"tilt", &T::tilt, "deg", within(0, 180), 0.0,
                      "They lean by a random angle up to this, to any side."},
            Number<T>{"least_scale", &T::least_scale, "1", within(0.001, 1000), 0.7,
                      "They are scaled by a random factor from this on."},
            Number<T>{"most_scale", &T::most_scale, "1", within(0.001, 1000), 1.3,
                      "The largest factor."},
            Choice<T, Align>{"align", &T::align, alignments, Align::upright,
                             "Along which direction their own z points: up, or away from the "
                             "ground."},
            Number<T>{"sink", &T::sink, "m", within(-longest, longest), 0.0,
                      "How far their origin lies in the ground, at scale 1."},
            Choice<T, Operation>{"op", &T::op, joins, Operation::unite,
                                 "How they join the ground: with a smooth foot (blend), a sharp "
                                 "one (union), or as holes (carve)."},
            Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u,
                                    "Of places, turns and scales."}},
        habitat_fields<T>());
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  /// Makes `tree`.
  void read_trees(const std::string& where, const ReadTree& read, std::vector<Problem>& problems);
  void grow(Growth& growth) const;

  /// Between two samples [m].
  double apart() const;
};

}  // namespace hoodoo::generator
