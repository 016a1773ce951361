#pragma once
#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Axis-aligned block: F = e g(max(0, d + 0.4542 R)), d the exact signed distance to its faces.
/// Source: Paris et al. 2019, section 5.2 (volumetric skeletons).
struct BoxNode : Volume {
  static constexpr std::string_view type = "box";
  static constexpr std::string_view doc =
      "Axis-aligned block: F = e g(max(0, d + 0.4542 R)), d the signed distance to its faces.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;
  Vec3 size{1, 1, 1};  // [m], edge to edge

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<BoxNode>{"center", &BoxNode::center, required, "Centre."},
                   Vector<BoxNode>{"size", &BoxNode::size, "m", above(0, longest), required,
                                   "Width, depth and height, edge to edge."}},
        volume_fields<BoxNode>());
  }
  double half_thickness() const { return std::min({size.x, size.y, size.z}) / 2; }
  Support support(std::span<const Support>) const {
    return support_of({center.value - size * 0.5, center.value + size * 0.5});
  }

  template <class S>
  struct Shape {
    S x, y, z, hx, hy, hz;  // centre and half sizes

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      const T qx = magnitude(dx) - hx, qy = magnitude(dy) - hy, qz = magnitude(dz) - hz;
      const T zero(S(0));
      const T ox = larger(qx, zero), oy = larger(qy, zero), oz = larger(qz, zero);
      const T outside = square_root(ox * ox + oy * oy + oz * oz);
      const T inside = smaller(larger(larger(qx, qy), qz), zero);
      // Outside, the boundary point is p held to the box; inside, p moved out through the
      // nearest face.
      const Scalar<T> q = std::max({value_of(qx), value_of(qy), value_of(qz)});
      const bool out = q > S(0);
      const auto place = [&](const T& d, const T& distance, S half) {
        if (!out && value_of(distance) < q) return d;
        if (out && value_of(distance) <= S(0)) return d;
        return T(value_of(d) < S(0) ? -half : half);
      };
      return {outside + inside, x + place(dx, qx, hx), y + place(dy, qy, hy),
              z + place(dz, qz, hz)};
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin;
    return {static_cast<S>(c.x),        static_cast<S>(c.y),        static_cast<S>(c.z),
            static_cast<S>(size.x / 2), static_cast<S>(size.y / 2), static_cast<S>(size.z / 2)};
  }
  friend bool operator==(const BoxNode&, const BoxNode&) = default;
};

}  // namespace hoodoo::tree
