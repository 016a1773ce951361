#pragma once
#include "engine/tree/distance.hpp"

namespace hoodoo::tree {

/// A distance tree as a field: F = clamp(1/2 - d / (2k), 0, 1). Source: DESIGN section 3.
struct FromDistance {
  static constexpr std::string_view type = "from_distance";
  static constexpr std::string_view doc =
      "A distance tree as a field: F = clamp(1/2 - d / (2k), 0, 1), d negative inside.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{
      Slot{"child", "The distance d [m].", 1, 1, false, Family::distance}};

  double falloff = 1;  // k [m]

  static constexpr auto fields() {
    return std::tuple{Number<FromDistance>{"falloff", &FromDistance::falloff, "m",
                                           above(0, longest), 1.0,
                                           "k: F falls from 1 to 0 between k inside and k "
                                           "outside."}};
  }
  /// The child's is that of distance_support.
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;

  template <class T>
  T field(const T& d) const {
    const T f = constant<T>(0.5) - d * constant<T>(0.5 / std::max(falloff, 1e-15));
    return smaller(larger(f, constant<T>(0)), constant<T>(1));
  }
  friend bool operator==(const FromDistance&, const FromDistance&) = default;
};

}  // namespace hoodoo::tree
