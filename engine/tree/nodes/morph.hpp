#pragma once
#include "engine/tree/combine.hpp"

namespace hoodoo::tree {

/// From one shape to another: F = A (1 - a) + B a. Source: Zawadzki, Nikiel, Ribeiro 2013, section
/// III.E, equation 14; on fields instead of distances, so that the support stays compact.
struct Morph {
  static constexpr std::string_view type = "morph";
  static constexpr std::string_view doc = "From one shape to another: F = A (1 - a) + B a.";
  static constexpr std::string_view cited =
      "Zawadzki, Nikiel, Ribeiro 2013, section III.E, equation 14";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"from", "A: the shape at a = 0.", 1, 1, false},
                                    Slot{"to", "B: the shape at a = 1.", 1, 1, false}};
  static constexpr Pick pick = Pick::none;
  static constexpr bool adds = true;  // a second child that is 0 changes nothing

  double amount = 0.5;  // a

  static constexpr auto fields() {
    return std::tuple{Number<Morph>{"amount", &Morph::amount, "1", within(0, 1), required,
                                    "How far it has come from A to B."}};
  }
  Support support(std::span<const Support> children) const {
    Support all = children[0];
    all.range = all.range * (1 - amount);
    all.slope = all.slope * (1 - amount);
    if (children.size() < 2) return all;
    all.influence.add(children[1].influence);
    all.range = all.range + children[1].range * amount;
    all.slope += children[1].slope * amount;
    return all;
  }

  template <class T>
  T first(const T& a) const {
    return a * constant<T>(1 - amount);
  }
  template <class T>
  T join(const T& a, const T& b) const {
    return a + b * constant<T>(amount);
  }
  template <class T>
  T last(const T& a) const {
    return a;
  }
  friend bool operator==(const Morph&, const Morph&) = default;
};

}  // namespace hoodoo::tree
