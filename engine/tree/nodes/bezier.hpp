#pragma once
#include "engine/tree/curve.hpp"

namespace hoodoo::tree {

/// Tube that falls off from a chain of cubic Bezier curves: F = e (1 - (r/R)^2)^3, r the distance
/// to the curve, flattened to `tolerance`, R = radius / 0.4542. Source: Paris et al. 2019, section
/// 5.2 (curve skeletons).
struct Bezier : Thin {
  static constexpr std::string_view type = "bezier";
  static constexpr std::string_view doc =
      "Tube that falls off from cubic Bezier curves: F = e (1 - (r/R)^2)^3, R = radius / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (curve skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  std::vector<Point> points;
  double tolerance = 0.05;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{
            Positions<Bezier>{"points", &Bezier::points, 4, 6001,
                              "Control points: an end, two handles, an end, two handles, an end "
                              "and so on; a curve passes through its ends."},
            Number<Bezier>{"tolerance", &Bezier::tolerance, "m", above(0, longest), 0.05,
                           "How far the lines that stand for the curve may leave it; at most 64 "
                           "lines per curve."}},
        thin_fields<Bezier>());
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    Thin::check(where, problems);
    if (points.size() % 3 != 1) {
      problems.push_back({where + "/points",
                          "must be 4, 7, 10, ... points: an end, then two "
                          "handles and an end for each curve"});
    }
  }
  Support support(std::span<const Support>) const { return support_of(hull(bezier(points))); }
  template <class S>
  using Shape = Polyline::Shape<S>;
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return curve_shape<S>(bezier(points), tolerance, radius, origin);
  }
  bool keep_near(Shape<float>& shape, const Block& block) const {
    return tree::keep_near(shape, reach() + turbulence.amplitude, block);
  }
  friend bool operator==(const Bezier&, const Bezier&) = default;
};

}  // namespace hoodoo::tree
