#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Ball that falls off from its centre: F = e (1 - (r/R)^2)^3, r = |p - c|, R = radius / 0.4542.
/// Source: Paris et al. 2019, section 5.2.
struct PointNode : Thin {
  static constexpr std::string_view type = "point";
  static constexpr std::string_view doc =
      "Ball that falls off from its centre: F = e (1 - (r/R)^2)^3, R = radius / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<PointNode>{"center", &PointNode::center, required, "Centre."}},
        thin_fields<PointNode>());
  }
  Support support(std::span<const Support>) const {
    return support_of({center.value, center.value});
  }

  template <class S>
  struct Shape {
    S x, y, z, radius;

    template <class T>
    T distance_squared(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      return dx * dx + dy * dy + dz * dz;
    }
    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      return star_projection(px, py, pz, T(x), T(y), T(z), radius);
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin;
    return {static_cast<S>(c.x), static_cast<S>(c.y), static_cast<S>(c.z), static_cast<S>(radius)};
  }
  friend bool operator==(const PointNode&, const PointNode&) = default;
};

}  // namespace hoodoo::tree
