#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/generator/growth.hpp"
#include "engine/generator/invasion.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/point.hpp"
#include "engine/tree/skeleton.hpp"

namespace hoodoo::generator {

/// Caves that water leaves in soft rock: invasion percolation from sinks of the input terrain, from
/// its cliffs and from places of the author's choice. One ball is carved per passage, of energy
/// `energy` e(rho, stress); where the step is longer than the radius, more between it and the one
/// before. Depths are below the input terrains; what earlier operations left is not looked at.
///
/// Reach: what grows from a start lies within `length` of it, no deeper than `depth`, and where the
/// region has weight. Starts know of each other only where their passages come as near as
/// `exclusion`, so that an edit changes the passages of starts within `length` of it and, through
/// those, of starts whose passages meet theirs.
/// Source: Paris et al. 2019, section 6.2, figures 13, 16, 17 and 24. The queue gives the least
/// resistant candidate, as the text of its steps has it.
struct PercolationKarst {
  static constexpr std::string_view type = "percolation_karst";
  static constexpr std::string_view doc =
      "Sinkholes, tunnels and caves: water enters at sinks, cliffs and seeds and invades the least "
      "resistant rock, mostly downward.";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 6.2; Wilkinson, Willemsen 1983";

  std::vector<tree::Point> seeds, resurgences;
  bool sinks = true;
  double min_sink_depth = 1;  // [m]
  double min_sink_area = 0;   // [m^2]
  double cliffs = 0;          // [m]
  double steepness = 55;      // [deg]
  double rho_0 = 0.5;         // [1]
  double epsilon = 0.1;       // [1]
  int directions = 8;
  double upward = 0;                             // [1]
  double pull = 0.5;                             // [1]
  double radius = 4;                             // [m]
  std::optional<double> step, exclusion, cover;  // [m]
  double depth = 200;                            // [m]
  double length = 500;                           // [m]
  std::uint32_t count = 1000;
  double energy = 2;  // [1]
  double stress = 1;  // [1]
  double beta = 0.1;  // [1]
  tree::StarTurbulence turbulence;
  std::uint32_t seed = 0;

  static constexpr auto start_fields() {
    using T = PercolationKarst;
    using namespace tree;
    return std::tuple{
        Positions<T>{"seeds", &T::seeds, 0, 100'000, "Where water enters the rock, beside sinks."},
        Positions<T>{"resurgences", &T::resurgences, 0, 1000,
                     "Where water leaves: passages near by turn towards the nearest, and paths "
                     "that reach one end there."},
        Flag<T>{"sinks", &T::sinks, true,
                "Water enters at the bottoms of the input terrain's depressions."},
        Number<T>{"min_sink_depth", &T::min_sink_depth, "m", within(0, longest), 1.0,
                  "Shallower depressions are no sinks."},
        Number<T>{"min_sink_area", &T::min_sink_area, "m^2", within(0, 1e12), 0.0,
                  "Smaller depressions are no sinks."},
        Number<T>{"cliffs", &T::cliffs, "m", within(0, longest), 0.0,
                  "Water enters at cliff faces too, at places this far apart; 0: it does not."},
        Number<T>{"steepness", &T::steepness, "deg", within(0, 180), 55.0,
                  "Least slope of a cliff face."}};
  }
  static constexpr auto spread_fields() {
    using T = PercolationKarst;
    using namespace tree;
    return std::tuple{
        Number<T>{"rho_0", &T::rho_0, "1", within(0, 2), 0.5,
                  "Rock of this resistance and more is left alone."},
        Number<T>{"epsilon", &T::epsilon, "1", within(0, 100), 0.1,
                  "Chance in the order: the least rho (1 + epsilon u) is next, u in [0, 1)."},
        Whole<T>{"directions", &T::directions, 1, 64, 8,
                 "Random directions tried from every passage."},
        Number<T>{"upward", &T::upward, "1", within(0, 1), 0.0,
                  "Greatest upward part of a direction: 0 falls or is level, 1 is any."},
        Number<T>{"pull", &T::pull, "1", within(0, 10), 0.5,
                  "Strength of resurgences beside a random direction of length 1."},
        OptionalNumber<T>{"step", &T::step, "m", above(0, longest),
                          "From passage to passage; by default the radius."},
        OptionalNumber<T>{"exclusion", &T::exclusion, "m", above(0, longest),
                          "Least distance between passages but for the one before, under twice the "
                          "step; by default 1.25 steps."},
        OptionalNumber<T>{"cover", &T::cover, "m", within(0, longest),
                          "Least depth of the middle of passages under the ground, away from "
                          "entrances and cliffs; 0 lets ceilings break. By default twice the "
                          "radius."},
        Number<T>{"depth", &T::depth, "m", above(0, longest), 200.0,
                  "Greatest depth of passages under the ground."},
        Number<T>{"length", &T::length, "m", above(0, longest), 500.0,
                  "Longest path from a start."},
        Whole<T, std::uint32_t>{"count", &T::count, 1, 1'000'000, 1000u,
                                "Most passages from one start."}};
  }
  static constexpr auto ball_fields() {
    using T = PercolationKarst;
    using namespace tree;
    return std::tuple{
        Number<T>{"radius", &T::radius, "m", above(0, longest), 4.0,
                  "Radius of the balls that are carved out."},
        Number<T>{"energy", &T::energy, "1", above(0, 100), 2.0,
                  "Energy of a ball where the effect is 1; others have the effect's share of it."},
        Number<T>{"stress", &T::stress, "1", within(0, 1), 1.0,
                  "s in the effect e = s (1 - rho)(1 - beta) + s beta."},
        Number<T>{"beta", &T::beta, "1", within(0, 1), 0.1,
                  "Effect on the hardest rock where the stress is greatest."},
        Group<T, StarTurbulence>{"turbulence", &T::turbulence, "Roughness of the walls."},
        Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u,
                                "Of directions and of the order."}};
  }
  static constexpr auto fields() {
    return std::tuple_cat(start_fields(), spread_fields(), ball_fields());
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  void grow(Growth& growth) const;

  double steps() const { return step.value_or(radius); }
  double exclusions() const { return exclusion.value_or(1.25 * steps()); }
};

}  // namespace hoodoo::generator
