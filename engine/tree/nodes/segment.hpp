#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Capsule that falls off from a line segment: F = e (1 - (r/R)^2)^3, r the distance to the
/// segment, R = radius / 0.4542. Source: Paris et al. 2019, section 5.2.
struct Segment : Thin {
  static constexpr std::string_view type = "segment";
  static constexpr std::string_view doc =
      "Capsule that falls off from a line segment: F = e (1 - (r/R)^2)^3, R = radius / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point from, to;

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Segment>{"from", &Segment::from, required, "One end."},
                   Position<Segment>{"to", &Segment::to, required, "The other end."}},
        thin_fields<Segment>());
  }
  Support support(std::span<const Support>) const {
    Box box{from.value, from.value};
    box.add(to.value);
    return support_of(box);
  }

  template <class S>
  struct Shape {
    S x, y, z, ux, uy, uz;  // from, and to - from
    S inverse_length2;      // 1 / |to - from|^2, 0 where both ends are one
    S radius;

    /// Fraction of the way along the segment of the point nearest to p.
    template <class T>
    T along(const T& dx, const T& dy, const T& dz) const {
      return clamped((dx * ux + dy * uy + dz * uz) * inverse_length2, S(0), S(1));
    }
    template <class T>
    T distance_squared(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      const T t = along(dx, dy, dz);
      const T ex = dx - t * ux, ey = dy - t * uy, ez = dz - t * uz;
      return ex * ex + ey * ey + ez * ez;
    }
    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T t = along(px - x, py - y, pz - z);
      return star_projection(px, py, pz, x + t * ux, y + t * uy, z + t * uz, radius);
    }
  };
  template <class S>
  static Shape<S> shape_between(const Vec3& a, const Vec3& b, double radius) {
    const Vec3 u = b - a;
    const double l2 = dot(u, u);
    return {static_cast<S>(a.x),
            static_cast<S>(a.y),
            static_cast<S>(a.z),
            static_cast<S>(u.x),
            static_cast<S>(u.y),
            static_cast<S>(u.z),
            static_cast<S>(l2 > 0 ? std::min(1 / l2, 1e30) : 0.0),
            static_cast<S>(radius)};
  }
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return shape_between<S>(from.value - origin, to.value - origin, radius);
  }
  friend bool operator==(const Segment&, const Segment&) = default;
};

}  // namespace hoodoo::tree
