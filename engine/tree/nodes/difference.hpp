#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// The first child without the others: F = min(F_1, 1 - F_2, 1 - F_3, ...).
/// Source: Paris et al. 2019, section 5.3, in normalised units (DESIGN section 3).
struct Difference {
  static constexpr std::string_view type = "difference";
  static constexpr std::string_view doc =
      "The first child without the others: F = min(F_1, 1 - F_2, 1 - F_3, ...).";
  static constexpr std::string_view cited = "Paris et al. 2019, section 5.3, in normalised units";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{
      Slot{"children", "The body, then what is taken away from it.", 1, any_number, true}};
  static constexpr Pick pick = Pick::smallest;
  static constexpr bool adds = false;
  static constexpr bool first_is_special = true;
  static constexpr auto fields() { return std::tuple{}; }
  Support support(std::span<const Support> children) const { return difference_support(children); }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return smaller(a, constant<T>(1) - b);
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  Interval term(std::size_t index, const Interval& child) const {
    return index == 0 ? child : Interval{1, 1} - child;
  }
  friend bool operator==(const Difference&, const Difference&) = default;
};

}  // namespace hoodoo::tree
