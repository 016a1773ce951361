#pragma once
#include <fmt/format.h>

#include "engine/base/error.hpp"
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// The child, held to a range: F = min(max(F_1, low), high). Where 0 lies outside the range it
/// fills all space. Source: DESIGN section 3 (resistances lie in [0, 1]).
struct Clamp {
  static constexpr std::string_view type = "clamp";
  static constexpr std::string_view doc =
      "The child, held to a range: F = min(max(F_1, low), high).";
  static constexpr std::string_view cited = "hoodoo: resistances lie in [0, 1]";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is held.", 1, 1, false}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = false;

  double low = 0, high = 1;

  static constexpr auto fields() {
    return std::tuple{
        Number<Clamp>{"low", &Clamp::low, "1", within(-1000, 1000), 0.0, "The least value."},
        Number<Clamp>{"high", &Clamp::high, "1", within(-1000, 1000), 1.0, "The largest value."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const {
    if (low > high) {
      problems.push_back(
          {where + "/high", fmt::format("must be at least \"low\", {}, got {}", low, high)});
    }
  }
  /// What becomes of 0.
  double of_zero() const { return std::clamp(0.0, low, high); }
  Support support(std::span<const Support> children) const {
    Support all = children[0];
    if (of_zero() != 0) all.influence = Box::everywhere();
    // As evaluation holds the ends: in single precision.
    const auto held = [](double v) { return static_cast<double>(static_cast<float>(v)); };
    all.range = clamp(all.range, held(low), held(high));
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return smaller(larger(a, constant<T>(low)), constant<T>(high));
  }
  template <class T>
  T join(const T& a, const T&) const {
    return a;
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const Clamp&, const Clamp&) = default;
};

}  // namespace hoodoo::tree
