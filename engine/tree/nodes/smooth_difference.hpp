#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// The first child a without the others b, with a fillet where they meet: with c = 1 - b,
/// max(min(a, c) - m^2 / (4 w), min(a, c, 0)), m = max(0, w - |a - c|), w = width max(0, 1 - a +
/// b). Source: DESIGN section 3; combine.hpp says why the width is scaled. The outer maximum keeps
/// the support that of the first child.
struct SmoothDifference {
  static constexpr std::string_view type = "smooth_difference";
  static constexpr std::string_view doc =
      "The first child a without the others b, with a fillet: min(a, 1 - b) - m^2 / (4 w), "
      "m = max(0, w - |a - 1 + b|), w = width max(0, 1 - a + b), not below min(a, 1 - b, 0).";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::terrain;
  static constexpr std::array slots{
      Slot{"children", "The body, then what is taken away from it.", 1, any_number, true}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = false;

  double width = 0.25;

  static constexpr auto fields() {
    return std::tuple{Number<SmoothDifference>{"width", &SmoothDifference::width, "1", above(0, 1),
                                               0.25,
                                               "Difference of F across which the fillet reaches."}};
  }
  Support support(std::span<const Support> children) const {
    Support all = difference_support(children);
    all.range.low = std::min(all.range.low, 0.0);
    for (std::size_t i = 1; i < children.size(); ++i) all.slope *= 1 + width / 2;
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a;
  }
  template <class T>
  T join(const T& a, const T& b) const {
    const T c = constant<T>(1) - b, least = smaller(a, c);
    return larger(least - fillet(constant<T>(1) - a, b, width), smaller(least, constant<T>(0)));
  }
  /// Grows with a and falls with b.
  Interval join(const Interval& a, const Interval& b) const {
    return {join(a.low, b.high), join(a.high, b.low)};
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const SmoothDifference&, const SmoothDifference&) = default;
};

}  // namespace hoodoo::tree
