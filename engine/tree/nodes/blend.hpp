#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// Sum: F = energy (F_1 + F_2 + ...), in the children's order. 0 without children.
/// Source: Paris et al. 2019, section 5.3 (and 4.2 for the resistance).
struct Blend {
  static constexpr std::string_view type = "blend";
  static constexpr std::string_view doc = "Sum: F = energy (F_1 + F_2 + ...).";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 5.3 (and 4.2 for the resistance)";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{
      Slot{"children", "What is added up, each with an energy of its own.", 0, any_number, true}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = true;  // a child that is 0 changes nothing

  double energy = 1;

  static constexpr auto fields() {
    return std::tuple{Number<Blend>{"energy", &Blend::energy, "1", within(-1000, 1000), 1.0,
                                    "Factor on the sum."}};
  }
  Support support(std::span<const Support> children) const {
    Support all{Box(), {0, 0}, 0};
    for (const Support& c : children) {
      all.influence.add(c.influence);
      all.range = all.range + c.range;
      all.slope += c.slope;
    }
    return {all.influence, all.range * energy, all.slope * std::abs(energy)};
  }

  template <class T>
  T first(const T& a) const {
    return constant<T>(0) + a;
  }
  template <class T>
  T join(const T& sum, const T& a) const {
    return sum + a;
  }
  template <class T>
  T last(const T& sum) const {
    return sum * constant<T>(energy);
  }
  friend bool operator==(const Blend&, const Blend&) = default;
};

}  // namespace hoodoo::tree
