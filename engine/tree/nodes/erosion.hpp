#pragma once
#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// Wears a shape down where its rock is soft: F = F_1 - a fD (1 - rho), fD the control field and
/// rho the resistance, both clamped to [0,1]. Without a child F_1 is 0, and the operation "blend"
/// wears what came before. Source: Paris et al. 2019, section 5.3, with an amplitude a (DESIGN
/// section 3).
struct Erosion {
  static constexpr std::string_view type = "erosion";
  static constexpr std::string_view doc =
      "Wears a shape down where its rock is soft: F = F_1 - a fD (1 - rho).";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.3, with an amplitude";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{
      Slot{"resistance", "rho: the geology that resists, in [0,1].", 1, 1, false, Family::geology},
      Slot{"control", "fD: where and how much, in [0,1].", 1, 1, false},
      Slot{"child", "What is worn; without it what a blend is added to.", 0, 1, false}};

  double amount = 1;  // a

  static constexpr auto fields() {
    return std::tuple{Number<Erosion>{"amount", &Erosion::amount, "1", within(0, 1000), 1.0,
                                      "What the softest rock loses of F; its surface lies at 1/2 "
                                      "and F falls from 1 to 0 across a falloff."}};
  }
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;

  template <class T>
  T worn(const T& f, const T& rho, const T& control) const {
    const T zero = constant<T>(0), one = constant<T>(1);
    const T soft = one - smaller(larger(rho, zero), one);
    return f - constant<T>(amount) * smaller(larger(control, zero), one) * soft;
  }
  friend bool operator==(const Erosion&, const Erosion&) = default;
};

}  // namespace hoodoo::tree
