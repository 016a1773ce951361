#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// Union with a fillet: max(a, b) + m^2 / (4 w), m = max(0, w - |a - b|), w = width max(0, a + b),
/// child by child. Source: DESIGN section 3; combine.hpp says why the width is scaled.
struct SmoothUnion {
  static constexpr std::string_view type = "smooth_union";
  static constexpr std::string_view doc =
      "Union with a fillet: max(a, b) + m^2 / (4 w), m = max(0, w - |a - b|), "
      "w = width max(0, a + b).";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{Slot{"children", "What is united.", 1, any_number, true}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = false;

  double width = 0.25;

  static constexpr auto fields() {
    return std::tuple{Number<SmoothUnion>{"width", &SmoothUnion::width, "1", above(0, 1), 0.25,
                                          "Difference of F across which the fillet reaches."}};
  }
  Support support(std::span<const Support> children) const {
    Support all = hull_of(children, [](const auto& a, const auto& b) { return larger(a, b); });
    for (std::size_t i = 1; i < children.size(); ++i) {
      all.range.high = std::max(all.range.high, all.range.high * (1 + width / 2));
      all.slope *= 1 + width / 2;
    }
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return larger(a, b) + fillet(a, b, width);
  }
  Interval join(const Interval& a, const Interval& b) const {
    return {join(a.low, b.low), join(a.high, b.high)};
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const SmoothUnion&, const SmoothUnion&) = default;
};

}  // namespace hoodoo::tree
