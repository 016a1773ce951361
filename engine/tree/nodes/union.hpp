#pragma once
#include "engine/tree/combine.hpp"
#include "engine/tree/packed_trees.hpp"

namespace hoodoo::tree {

/// F = max(F_1, F_2, ...). Source: Paris et al. 2019, section 5.3 (printed the other way round).
/// Many children may be held packed, in place of children (pack.hpp).
struct Union {
  static constexpr std::string_view type = "union";
  static constexpr std::string_view doc = "F = max(F_1, F_2, ...).";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 5.3 (printed the other way round)";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{Slot{"children", "What is united.", 1, any_number, true}};
  static constexpr Pick pick = Pick::largest;
  static constexpr bool adds = false;
  static constexpr bool first_is_special = false;

  PackedTrees packed;

  static constexpr auto fields() { return std::tuple{}; }
  Support support(std::span<const Support> children) const {
    return hull_of(children, [](const auto& a, const auto& b) { return larger(a, b); });
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return larger(a, b);
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  Interval term(std::size_t, const Interval& child) const { return child; }
  friend bool operator==(const Union&, const Union&) = default;
};

}  // namespace hoodoo::tree
