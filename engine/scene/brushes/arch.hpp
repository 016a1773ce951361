#pragma once
#include <optional>

#include "engine/scene/brushes/stroke.hpp"

namespace hoodoo::scene {

/// A natural bridge: a rib that rises from one foot and comes down on the other, along a parabola.
struct ArchBrush : Stroke {
  static constexpr std::string_view type = "arch";
  static constexpr std::string_view doc =
      "A natural bridge: a rib that rises from one foot and comes down on the other.";

  tree::Point from, to;
  double height = 1;                     // [m]
  double thickness = 1;                  // [m]
  std::optional<double> foot_thickness;  // [m]

  static constexpr auto fields() {
    using T = ArchBrush;
    using namespace tree;
    return std::tuple_cat(
        std::tuple{Position<T>{"from", &T::from, required, "One foot, on the rib's axis."},
                   Position<T>{"to", &T::to, required, "The other foot."},
                   Number<T>{"height", &T::height, "m", within(0, longest), required,
                             "How far the axis rises halfway above the line between the feet."},
                   Number<T>{"thickness", &T::thickness, "m", above(0, longest), required,
                             "Thickness halfway."},
                   OptionalNumber<T>{"foot_thickness", &T::foot_thickness, "m", above(0, longest),
                                     "Thickness at the feet; by default one and a half times that "
                                     "halfway."}},
        stroke_fields<T>(Operation::unite));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_tube(std::min(thickness, foot_thickness.value_or(thickness)) / 2, turbulence, where,
               problems);
  }
  tree::Node build() const {
    constexpr int lines = 32;
    const double crown = thickness / 2, foot = foot_thickness.value_or(1.5 * thickness) / 2;
    std::vector<Bead> chain;
    for (int i = 0; i <= lines; ++i) {
      const double t = static_cast<double>(i) / lines, side = 2 * t - 1;
      const Vec3 at = from.value + (to.value - from.value) * t;
      chain.push_back(
          {at + Vec3{0, 0, height * (1 - side * side)}, crown + (foot - crown) * side * side});
    }
    return tube(chain, turbulence);
  }
};

}  // namespace hoodoo::scene
