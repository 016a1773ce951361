#pragma once
#include "engine/tree/curve.hpp"

namespace hoodoo::tree {

/// Tube that falls off from a Catmull-Rom curve: F = e (1 - (r/R)^2)^3, r the distance to the
/// curve, flattened to `tolerance`, R = radius / 0.4542. Source: Paris et al. 2019, section 5.2
/// (curve skeletons).
struct CatmullRom : Thin {
  static constexpr std::string_view type = "catmull_rom";
  static constexpr std::string_view doc =
      "Tube that falls off from a smooth curve through points (Catmull-Rom): "
      "F = e (1 - (r/R)^2)^3, R = radius / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (curve skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  std::vector<Point> points;
  bool closed = false;
  double tolerance = 0.05;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{
            Positions<CatmullRom>{"points", &CatmullRom::points, 2, 2000, "Where it passes."},
            Flag<CatmullRom>{"closed", &CatmullRom::closed, false,
                             "The last point is joined to the first."},
            Number<CatmullRom>{"tolerance", &CatmullRom::tolerance, "m", above(0, longest), 0.05,
                               "How far the lines that stand for the curve may leave it; at most "
                               "64 lines per point."}},
        thin_fields<CatmullRom>());
  }
  Support support(std::span<const Support>) const {
    return support_of(hull(catmull_rom(points, closed)));
  }
  template <class S>
  using Shape = Polyline::Shape<S>;
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return curve_shape<S>(catmull_rom(points, closed), tolerance, radius, origin);
  }
  bool keep_near(Shape<float>& shape, const Block& block) const {
    return tree::keep_near(shape, reach() + turbulence.amplitude, block);
  }
  friend bool operator==(const CatmullRom&, const CatmullRom&) = default;
};

}  // namespace hoodoo::tree
