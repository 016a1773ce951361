#pragma once
#include <fmt/format.h>

#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Ring: F = e g(max(0, d + 0.4542 R)), d = sqrt((q - radius)^2 + h^2) - tube, q the distance to
/// the axis and h the height over the ring's plane. Source: Paris et al. 2019, section 5.2
/// (volumetric skeletons).
struct Torus : Volume {
  static constexpr std::string_view type = "torus";
  static constexpr std::string_view doc =
      "Ring: F = e g(max(0, d + 0.4542 R)), d = sqrt((q - radius)^2 + h^2) - tube.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;
  Vec3 axis{0, 0, 1};
  double radius = 1;  // [m]
  double tube = 1;    // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{
            Position<Torus>{"center", &Torus::center, required, "Centre."},
            Direction<Torus>{"axis", &Torus::axis, Vec3{0, 0, 1}, "Perpendicular to the ring."},
            Number<Torus>{"radius", &Torus::radius, "m", above(0, longest), required,
                          "From the centre to the middle of the tube."},
            Number<Torus>{"tube", &Torus::tube, "m", above(0, longest), required,
                          "Radius of the tube."}},
        volume_fields<Torus>());
  }
  double half_thickness() const { return tube; }
  Support support(std::span<const Support>) const {
    const Vec3 a = normalized(axis);
    const auto across = [&](double u) { return radius * std::sqrt(std::max(0.0, 1 - u * u)); };
    const Vec3 disk{across(a.x), across(a.y), across(a.z)};
    return support_of(Box{center.value - disk, center.value + disk}.grown(tube));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (tube > radius) {
      problems.push_back(
          {where + "/tube",
           fmt::format("must be at most the radius, {:.6g} m, got {}", radius, tube)});
    }
  }

  template <class S>
  struct Shape {
    S x, y, z, ax, ay, az, radius, tube;

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      const T h = dx * ax + dy * ay + dz * az;
      const T ex = dx - h * ax, ey = dy - h * ay, ez = dz - h * az;
      const T q = square_root(ex * ex + ey * ey + ez * ez);
      const T f = T(radius) / larger(q, T(S(1e-12)));
      auto p = star_projection(px, py, pz, x + f * ex, y + f * ey, z + f * ez, tube);
      // From q, not from the circle's point: exact on the axis, too.
      p.distance = square_root((q - radius) * (q - radius) + h * h) - tube;
      return p;
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin, a = normalized(axis);
    return {static_cast<S>(c.x), static_cast<S>(c.y), static_cast<S>(c.z),    static_cast<S>(a.x),
            static_cast<S>(a.y), static_cast<S>(a.z), static_cast<S>(radius), static_cast<S>(tube)};
  }
  friend bool operator==(const Torus&, const Torus&) = default;
};

}  // namespace hoodoo::tree
