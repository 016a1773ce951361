#pragma once
#include <optional>

#include "engine/scene/brushes/stroke.hpp"

namespace hoodoo::scene {

/// A ball, added or removed.
struct SphereBrush : Stroke {
  static constexpr std::string_view type = "sphere";
  static constexpr std::string_view doc = "A ball, added or removed.";

  tree::Point center;
  double radius = 1;              // [m]
  std::optional<double> falloff;  // [m]

  static constexpr auto fields() {
    using T = SphereBrush;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{Position<T>{"center", &T::center, required, "Centre."},
                   Number<T>{"radius", &T::radius, "m", above(0, longest), required,
                             "Distance from the centre to the surface."},
                   OptionalNumber<T>{"falloff", &T::falloff, "m", above(0, longest),
                                     "Width over which the field falls from its peak to 0; by "
                                     "default the radius."}},
        stroke_fields<T>(Operation::unite));
  }
  tree::Node build() const {
    tree::Sphere ball;
    ball.center = center;
    ball.radius = radius;
    ball.falloff = falloff.value_or(radius);
    ball.turbulence = turbulence;
    return {ball, {}};
  }
};

}  // namespace hoodoo::scene
