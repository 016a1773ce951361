#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// Product: F = F_1 F_2 ... Source: DESIGN section 3 (geology); it confines one field to another.
struct Multiply {
  static constexpr std::string_view type = "multiply";
  static constexpr std::string_view doc = "Product: F = F_1 F_2 ...";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"children", "What is multiplied.", 1, 8, true}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = false;
  static constexpr auto fields() { return std::tuple{}; }
  /// 0 wherever a child is.
  Support support(std::span<const Support> children) const {
    Support all{Box::everywhere(), {1, 1}, 0};
    for (std::size_t i = 0; i < children.size(); ++i) {
      all.influence = intersection(all.influence, children[i].influence);
      all.range = all.range * children[i].range;
      double slope = children[i].slope;
      for (std::size_t j = 0; j < children.size(); ++j) {
        const Interval& r = children[j].range;
        // Not 0: an infinite slope times 0 is no number.
        if (j != i && slope > 0) slope *= std::max({std::abs(r.low), std::abs(r.high), 1e-300});
      }
      all.slope += slope;
    }
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return a * b;
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const Multiply&, const Multiply&) = default;
};

}  // namespace hoodoo::tree
