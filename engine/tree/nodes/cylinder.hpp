#pragma once
#include "engine/tree/frustum.hpp"

namespace hoodoo::tree {

/// Right circular cylinder: F = e g(max(0, d + 0.4542 R)), d the exact signed distance to both
/// discs and the mantle. Source: Paris et al. 2019, section 5.2 (volumetric skeletons).
struct Cylinder : Volume {
  static constexpr std::string_view type = "cylinder";
  static constexpr std::string_view doc =
      "Right circular cylinder: F = e g(max(0, d + 0.4542 R)), d the signed distance to its "
      "surface.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point base, top;
  double radius = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Position<Cylinder>{"base", &Cylinder::base, required, "Centre of one end."},
                   Position<Cylinder>{"top", &Cylinder::top, required, "Centre of the other."},
                   Number<Cylinder>{"radius", &Cylinder::radius, "m", above(0, longest), required,
                                    "Distance from the axis to the mantle."}},
        volume_fields<Cylinder>());
  }
  double half_thickness() const {
    return frustum_ball(length(top.value - base.value), radius, radius);
  }
  Support support(std::span<const Support>) const {
    return support_of(frustum_box(base.value, top.value, radius, radius));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (base == top) problems.push_back({where + "/top", "must not be where the base is"});
  }
  template <class S>
  using Shape = Frustum<S>;
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return frustum_between<S>(base.value - origin, top.value - origin, radius, radius);
  }
  friend bool operator==(const Cylinder&, const Cylinder&) = default;
};

}  // namespace hoodoo::tree
