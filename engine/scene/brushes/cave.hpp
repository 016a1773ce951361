#pragma once
#include <optional>

#include "engine/base/random.hpp"
#include "engine/scene/brushes/stroke.hpp"

namespace hoodoo::scene {

/// A cave: a winding passage from an entrance into the rock, ending in a chamber.
struct CaveBrush : Stroke {
  static constexpr std::string_view type = "cave";
  static constexpr std::string_view doc =
      "A cave: a winding passage from an entrance into the rock, ending in a chamber.";

  tree::Point entrance;
  Vec3 direction{0, 1, 0};
  double depth = 1;                      // [m]
  double radius = 1;                     // [m]
  std::optional<double> chamber_radius;  // [m]
  double winding = 0.5;
  std::uint32_t seed = 0;

  static constexpr auto fields() {
    using T = CaveBrush;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{
            Position<T>{"entrance", &T::entrance, required, "Centre of the mouth."},
            Direction<T>{"direction", &T::direction, required, "The way in."},
            Number<T>{"depth", &T::depth, "m", above(0, longest), required,
                      "From the mouth to the centre of the chamber."},
            Number<T>{"radius", &T::radius, "m", above(0, longest), required,
                      "Of the mouth and the passage."},
            OptionalNumber<T>{"chamber_radius", &T::chamber_radius, "m", above(0, longest),
                              "Of the chamber; by default one and a half times the passage's."},
            Number<T>{"winding", &T::winding, "radii", within(0, 10), 0.5,
                      "How far the passage strays sideways at most."},
            Whole<T, std::uint32_t>{"seed", &T::seed, 0, 4294967295LL, 0u, "Which way it winds."}},
        stroke_fields<T>(Operation::difference));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  tree::Node build() const;
};

}  // namespace hoodoo::scene
