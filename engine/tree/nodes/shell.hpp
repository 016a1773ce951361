#pragma once
#include "engine/tree/distance.hpp"

namespace hoodoo::tree {

/// A wall along the surface, half on either side: d = |d_1| - thickness / 2. Source: DESIGN section
/// 3 (distance trees).
struct Shell {
  static constexpr std::string_view type = "shell";
  static constexpr std::string_view doc =
      "A wall along the surface, half on either side: d = |d_1| - thickness / 2.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::distance;
  static constexpr std::array slots{Slot{"child", "Whose surface it follows.", 1, 1, false}};

  double wall = 1;  // [m]

  static constexpr auto fields() {
    return std::tuple{
        Number<Shell>{"thickness", &Shell::wall, "m", above(0, longest), required, "Of the wall."}};
  }
  Support support(std::span<const Support> children) const {
    return {children[0].influence.grown(wall / 2), Interval::everything(), children[0].slope};
  }
  double thickness(double) const { return wall; }
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;

  template <class T>
  T start(const T& d) const {
    return magnitude(d) - constant<T>(wall / 2);
  }
  template <class T>
  T meet(const T& d, const T&) const {
    return d;
  }
  friend bool operator==(const Shell&, const Shell&) = default;
};

}  // namespace hoodoo::tree
