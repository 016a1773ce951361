#pragma once
#include "engine/tree/frustum.hpp"

namespace hoodoo::tree {

/// Cone without its tip: F = e g(max(0, d + 0.4542 R)), d the exact signed distance to both discs
/// and the mantle. Source: Paris et al. 2019, section 5.2 (volumetric skeletons).
struct TruncatedCone : Volume {
  static constexpr std::string_view type = "truncated_cone";
  static constexpr std::string_view doc =
      "Cone without its tip: F = e g(max(0, d + 0.4542 R)), d the signed distance to its surface.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.2 (volumetric skeletons)";
  static constexpr Family family = Family::any;
  static constexpr auto slots = no_slots;

  Point base, top;
  double base_radius = 1, top_radius = 1;  // [m]

  static constexpr auto fields() {
    using T = TruncatedCone;
    return std::tuple_cat(
        std::tuple{Position<T>{"base", &T::base, required, "Centre of the base."},
                   Position<T>{"top", &T::top, required, "Centre of the top."},
                   Number<T>{"base_radius", &T::base_radius, "m", above(0, longest), required,
                             "Radius of the base."},
                   Number<T>{"top_radius", &T::top_radius, "m", above(0, longest), required,
                             "Radius of the top; either may be the wider."}},
        volume_fields<T>());
  }
  double half_thickness() const {
    return frustum_ball(length(top.value - base.value), base_radius, top_radius);
  }
  Support support(std::span<const Support>) const {
    return support_of(frustum_box(base.value, top.value, base_radius, top_radius));
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (base == top) problems.push_back({where + "/top", "must not be where the base is"});
  }
  template <class S>
  using Shape = Frustum<S>;
  template <class S>
  Shape<S> shape(const Vec3& origin) const {
    return frustum_between<S>(base.value - origin, top.value - origin, base_radius, top_radius);
  }
  friend bool operator==(const TruncatedCone&, const TruncatedCone&) = default;
};

}  // namespace hoodoo::tree
