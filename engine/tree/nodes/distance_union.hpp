#pragma once
#include "engine/tree/combine.hpp"
#include "engine/tree/distance.hpp"

namespace hoodoo::tree {

/// Union with a fillet of stated width: d = min(a, b) - m^2 / (4 k), m = max(0, k - |a - b|), child
/// by child; a plain union where k = 0. Source: DESIGN section 3 (distance trees).
struct DistanceUnion {
  static constexpr std::string_view type = "distance_union";
  static constexpr std::string_view doc =
      "Union with a fillet: d = min(a, b) - m^2 / (4 k), m = max(0, k - |a - b|).";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::distance;
  static constexpr std::array slots{Slot{"children", "What is united.", 1, any_number, true}};

  double width = 0;  // k [m]

  static constexpr auto fields() {
    return std::tuple{
        Number<DistanceUnion>{"width", &DistanceUnion::width, "m", within(0, longest), 0.0,
                              "k: where distances differ by less, the fillet reaches."}};
  }
  Support support(std::span<const Support> children) const {
    Support all = hull_of(children, [](const Interval& a, const Interval&) { return a; });
    if (children.size() > 1) {
      all.influence = all.influence.grown(width / 4 * static_cast<double>(children.size() - 1));
    }
    return all;
  }
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;

  template <class T>
  T start(const T& d) const {
    return d;
  }
  template <class T>
  T meet(const T& a, const T& b) const {
    return smaller(a, b) - metric_fillet(a, b, width);
  }
  /// Grows with a and with b.
  Interval meet(const Interval& a, const Interval& b) const {
    return {meet(a.low, b.low), meet(a.high, b.high)};
  }
  friend bool operator==(const DistanceUnion&, const DistanceUnion&) = default;
};

}  // namespace hoodoo::tree
