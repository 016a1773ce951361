#pragma once
#include "engine/scene/brushes/stroke.hpp"

namespace hoodoo::scene {

/// A passage along a path, open wherever the path leaves the rock.
struct TunnelBrush : Stroke {
  static constexpr std::string_view type = "tunnel";
  static constexpr std::string_view doc =
      "A passage along a path, open wherever the path leaves the rock.";

  std::vector<tree::Point> path;
  double radius = 1;  // [m]
  bool smooth = true;

  static constexpr auto fields() {
    using T = TunnelBrush;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{Positions<T>{"path", &T::path, 2, 10'000, "Where its axis passes."},
                   Number<T>{"radius", &T::radius, "m", above(0, longest), required,
                             "Distance from the axis to the wall."},
                   Flag<T>{"smooth", &T::smooth, true,
                           "Bend smoothly through the points; else go straight between them."}},
        stroke_fields<T>(Operation::difference));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_tube(radius, turbulence, where, problems);
  }
  tree::Node build() const {
    const auto chain = places(path);
    return tube(smooth ? smooth_curve(chain, radius) : chain, radius, turbulence);
  }
};

}  // namespace hoodoo::scene
