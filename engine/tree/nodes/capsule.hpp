#pragma once
#include "engine/tree/nodes/segment.hpp"

namespace hoodoo::tree {

/// Cylinder with round ends, solid throughout: F = e g(max(0, d + 0.4542 R)), d the distance to the
/// segment less `radius`. Source: Paris et al. 2019, section 5.2 (volumetric skeletons).
struct Capsule : Volume {
  static constexpr std::string_view type = "capsule";
  static constexpr std::string_view doc =
      "Cylinder with round ends: F = e g(max(0, d + 0.4542 R)), d the distance to the segment less "
      "radius.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point from, to;
  double radius = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Capsule>{"from", &Capsule::from, required, "Centre of one round end."},
                   Position<Capsule>{"to", &Capsule::to, required, "Centre of the other."},
                   Number<Capsule>{"radius", &Capsule::radius, "m", above(0, longest), required,
                                   "Distance from the line between them to the surface."}},
        volume_fields<Capsule>());
  }
  double half_thickness() const { return radius; }
  Support support(std::span<const Support>) const {
    Box box{from.value, from.value};
    box.add(to.value);
    return support_of(box.grown(radius));
  }

  template <class S>
  struct Shape {
    Segment::Shape<S> axis;

    template <class T>
    Projection<T> project(const T& px, const T& py, const T& pz) const {
      Projection<T> p = axis.project(px, py, pz);
      p.distance = p.distance - axis.radius;
      return p;
    }
  };
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return {Segment::shape_between<S>(from.value - origin, to.value - origin, radius)};
  }
  friend bool operator==(const Capsule&, const Capsule&) = default;
};

}  // namespace hoodoo::tree
