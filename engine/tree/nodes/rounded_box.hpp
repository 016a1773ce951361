#pragma once
#include <fmt/format.h>

#include "engine/tree/skeleton.hpp"

namespace hoodoo::tree {

/// Axis-aligned block with rounded edges: F = e g(max(0, d + 0.4542 R)), d the exact signed
/// distance: that to a block smaller by `rounding`, less `rounding`. Source: Paris et al. 2019,
/// section 5.2 (volumetric skeletons).
struct RoundedBox : Volume {
  static constexpr std::string_view type = "rounded_box";
  static constexpr std::string_view doc =
      "Axis-aligned block with rounded edges: F = e g(max(0, d + 0.4542 R)), d the signed distance "
      "to its surface.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point center;
  Vec3 size{1, 1, 1};   // [m], face to face
  double rounding = 0;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<RoundedBox>{"center", &RoundedBox::center, required, "Centre."},
                   Vector<RoundedBox>{"size", &RoundedBox::size, "m", above(0, longest), required,
                                      "Width, depth and height, face to face."},
                   Number<RoundedBox>{"rounding", &RoundedBox::rounding, "m", within(0, longest),
                                      required, "Radius of edges and corners."}},
        volume_fields<RoundedBox>());
  }
  double half_thickness() const { return std::min({size.x, size.y, size.z}) / 2; }
  Support support(std::span<const Support>) const {
    return support_of({center.value - size * 0.5, center.value + size * 0.5});
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (rounding > half_thickness()) {
      problems.push_back(
          {where + "/rounding", fmt::format("must be at most half the least size, {:.6g} m, got {}",
                                            half_thickness(), rounding)});
    }
  }

  template <class S>
  struct Shape {
    S x, y, z, hx, hy, hz, radius;  // centre, half sizes of the inner block, rounding

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      const T dx = px - x, dy = py - y, dz = pz - z;
      const T qx = magnitude(dx) - hx, qy = magnitude(dy) - hy, qz = magnitude(dz) - hz;
      const T zero(S(0));
      const T ox = larger(qx, zero), oy = larger(qy, zero), oz = larger(qz, zero);
      const T outside = square_root(ox * ox + oy * oy + oz * oz);
      const T inside = smaller(larger(larger(qx, qy), qz), zero);
      // From the inner block's nearest point outward by the rounding; within the inner block,
      // through the nearest face.
      const Scalar<T> q = std::max({value_of(qx), value_of(qy), value_of(qz)});
      const bool out = q > S(0);
      const T f = T(radius) / larger(outside, T(S(1e-12)));
      const auto place = [&](const T& d, const T& past, const T& over, S half) {
        const T held = value_of(d) < S(0) ? T(-half) : T(half);
        const T lift = value_of(d) < S(0) ? -(f * over) : f * over;
        if (out) return value_of(past) > S(0) ? held + lift : d;
        if (value_of(past) < q) return d;
        return value_of(d) < S(0) ? T(-half - radius) : T(half + radius);
      };
      return {outside + inside - radius, x + place(dx, qx, ox, hx), y + place(dy, qy, oy, hy),
              z + place(dz, qz, oz, hz)};
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    const Vec3 c = center.value - origin;
    const auto half = [&](double edge) { return static_cast<S>(edge / 2 - rounding); };
    return {static_cast<S>(c.x), static_cast<S>(c.y), static_cast<S>(c.z),     half(size.x),
            half(size.y),        half(size.z),        static_cast<S>(rounding)};
  }
  friend bool operator==(const RoundedBox&, const RoundedBox&) = default;
};

}  // namespace hoodoo::tree
