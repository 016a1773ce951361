#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// F = min(F_1, F_2, ...). Source: Paris et al. 2019, section 5.3 (printed the other way round).
struct Intersection {
  static constexpr std::string_view type = "intersection";
  static constexpr std::string_view doc = "F = min(F_1, F_2, ...).";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 5.3 (printed the other way round)";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{Slot{"children", "What is intersected.", 1, any_number, true}};
  static constexpr Pick pick = Pick::smallest;
  static constexpr bool adds = false;
  static constexpr bool first_is_special = false;
  static constexpr auto fields() { return std::tuple{}; }
  /// Where every child is at least 0, one that is 0 settles the minimum.
  Support support(std::span<const Support> children) const {
    Support all = hull_of(children, [](const auto& a, const auto& b) { return smaller(a, b); });
    if (all.range.low >= 0) {
      all.influence = Box::everywhere();
      for (const Support& c : children) all.influence = intersection(all.influence, c.influence);
    }
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return smaller(a, b);
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  Interval term(std::size_t, const Interval& child) const { return child; }
  friend bool operator==(const Intersection&, const Intersection&) = default;
};

}  // namespace hoodoo::tree
