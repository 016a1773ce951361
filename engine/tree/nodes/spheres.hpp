#pragma once
#include "engine/tree/ball_set.hpp"

namespace hoodoo::tree {

/// Many spheres of one falloff, summed in their order: F = e_1 g(max(0, d_1 + 0.4542 R)) + ...,
/// d_i = |p - center_i| - radius_i. The same bits as a blend of such spheres.
/// Source: Paris et al. 2019, sections 5.2 and 5.3.
struct SphereSet : BallSet {
  static constexpr std::string_view type = "spheres";
  static constexpr std::string_view doc =
      "Many spheres, summed: F = e_1 g(max(0, d_1 + 0.4542 R)) + ..., d_i = |p - center_i| - "
      "radius_i.";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 5.2 and 5.3";
  static constexpr bool thin = false;

  double falloff = 4;  // R [m]

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple{Number<SphereSet>{"falloff", &SphereSet::falloff, "m", above(0, longest), 4.0,
                                     "Width over which the field falls from its peak to 0."}},
        ball_set_fields<SphereSet>());
  }
  double stretch() const { return 1; }
  double margin() const { return falloff * (1 - half_falloff) + turbulence.amplitude; }
  /// R [m] of a ball.
  double reach(double) const { return falloff; }
  Support support(std::span<const Support>) const { return ball_set_support(*this); }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    check_source(*this, where, problems);
  }
  friend bool operator==(const SphereSet&, const SphereSet&) = default;
};

}  // namespace hoodoo::tree
