#pragma once
#include "engine/tree/ball_set.hpp"

namespace hoodoo::tree {

/// Many points, summed in their order: F = e_1 (1 - (r_1/R_1)^2)^3 + ..., R_i = radius_i / 0.4542.
/// The same bits as a blend of such points. Source: Paris et al. 2019, sections 5.2 and 5.3.
struct PointSet : BallSet {
  static constexpr std::string_view type = "points";
  static constexpr std::string_view doc =
      "Many points, summed: F = e_1 (1 - (r_1/R_1)^2)^3 + ..., R_i = radius_i / 0.4542.";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 5.2 and 5.3";
  static constexpr bool thin = true;

  static constexpr auto fields() { return ball_set_fields<PointSet>(); }
  double stretch() const { return 1 / half_falloff; }
  double margin() const { return turbulence.amplitude; }
  /// R [m] of a ball.
  double reach(double radius) const { return radius / half_falloff; }
  Support support(std::span<const Support>) const { return ball_set_support(*this); }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  /// The roughness leaves something of a ball of the least radius [m].
  void check_least(double least_radius, const std::string& where,
                   std::vector<Problem>& problems) const;
  friend bool operator==(const PointSet&, const PointSet&) = default;
};

}  // namespace hoodoo::tree
