#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Ball: F = e g(max(0, d + 0.4542 R)), d = |p - c| - radius. Source: Paris et al. 2019,
/// section 5.2.
struct Sphere : Volume {
  static constexpr std::string_view type = "sphere";
  static constexpr std::string_view doc =
      "Ball: F = e g(max(0, d + 0.4542 R)), d = |p - center| - radius.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;
  double radius = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Sphere>{"center", &Sphere::center, required, "Centre."},
                   Number<Sphere>{"radius", &Sphere::radius, "m", above(0, longest), required,
                                  "Distance from the centre to the surface."}},
        volume_fields<Sphere>());
  }
  double half_thickness() const { return radius; }
  Support support(std::span<const Support>) const {
    return support_of(Box{center.value, center.value}.grown(radius));
  }

  template <class S>
  struct Shape {
    S x, y, z, radius;

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      auto p = star_projection(px, py, pz, T(x), T(y), T(z), radius);
      p.distance = p.distance - radius;
      return p;
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin;
    return {static_cast<S>(c.x), static_cast<S>(c.y), static_cast<S>(c.z), static_cast<S>(radius)};
  }
  friend bool operator==(const Sphere&, const Sphere&) = default;
};

}  // namespace hoodoo::tree
