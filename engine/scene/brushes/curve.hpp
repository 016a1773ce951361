#pragma once
#include "engine/scene/brushes/stroke.hpp"

namespace hoodoo::scene {

/// A tube along a curve, added or removed.
struct CurveBrush : Stroke {
  static constexpr std::string_view type = "curve";
  static constexpr std::string_view doc = "A tube along a curve, added or removed.";

  std::vector<tree::Point> points;
  double radius = 1;  // [m]
  bool smooth = true;

  static constexpr auto fields() {
    using T = CurveBrush;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{Positions<T>{"points", &T::points, 2, 10'000, "Where it passes."},
                   Number<T>{"radius", &T::radius, "m", above(0, longest), required,
                             "Distance from the curve to the surface."},
                   Flag<T>{"smooth", &T::smooth, true,
                           "Bend smoothly through the points; else go straight between them."}},
        stroke_fields<T>(Operation::unite));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_tube(radius, turbulence, where, problems);
  }
  tree::Node build() const {
    const auto chain = places(points);
    return tube(smooth ? smooth_curve(chain, radius) : chain, radius, turbulence);
  }
};

}  // namespace hoodoo::scene
