#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// Blend with negative energy: F = F_1 - F_2 - F_3 - ...: the first child, hollowed by the others.
/// Source: Paris et al. 2019, sections 5.3 and 6.
struct Carve {
  static constexpr std::string_view type = "carve";
  static constexpr std::string_view doc = "Blend with negative energy: F = F_1 - F_2 - ...";
  static constexpr std::string_view cited = "Paris et al. 2019, sections 5.3 and 6";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{
      Slot{"children", "The body, then what is carved out of it.", 1, any_number, true}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = true;  // a child that is 0 changes nothing
  static constexpr auto fields() { return std::tuple{}; }
  Support support(std::span<const Support> children) const {
    Support all = children[0];
    for (const Support& c : children.subspan(1)) {
      all.influence.add(c.influence);
      all.range = all.range - c.range;
      all.slope += c.slope;
    }
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& rest, const T& a) const {
    return rest - a;
  }
  template <class T>
  T last(const T& rest) const {
    return rest;
  }
  friend bool operator==(const Carve&, const Carve&) = default;
};

}  // namespace hoodoo::tree
