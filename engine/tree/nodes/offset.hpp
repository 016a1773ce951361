#pragma once
#include "engine/tree/distance.hpp"

namespace hoodoo::tree {

/// Thicker on all sides, thinner where negative: d = d_1 - by. Source: DESIGN section 3 (distance
/// trees).
struct Offset {
  static constexpr std::string_view type = "offset";
  static constexpr std::string_view doc =
      "Thicker on all sides, thinner where negative: d = d_1 - by.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::distance;
  static constexpr std::array slots{Slot{"child", "What grows.", 1, 1, false}};

  double by = 0;  // [m]

  static constexpr auto fields() {
    return std::tuple{Number<Offset>{"by", &Offset::by, "m", within(-longest, longest), required,
                                     "How far its surface moves out."}};
  }
  Support support(std::span<const Support> children) const {
    return {children[0].influence.grown(std::max(0.0, by)), Interval::everything(),
            children[0].slope};
  }
  double thickness(double of_child) const { return std::max(0.0, of_child + 2 * by); }
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;

  template <class T>
  T start(const T& d) const {
    return d - constant<T>(by);
  }
  template <class T>
  T meet(const T& d, const T&) const {
    return d;
  }
  friend bool operator==(const Offset&, const Offset&) = default;
};

}  // namespace hoodoo::tree
