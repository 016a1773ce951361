#pragma once
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// The child, stretched about a pivot: F(p) = F_1(pivot + (p - pivot) / by), axis by axis.
/// Falloffs are stretched with it.
struct Scale {
  static constexpr std::string_view type = "scale";
  static constexpr std::string_view doc =
      "The child, stretched about a pivot: F(p) = F_1(pivot + (p - pivot) / by), axis by axis.";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is stretched.", 1, 1, false}};

  Vec3 by{1, 1, 1};
  Point pivot;

  static constexpr auto fields() {
    return std::tuple{Vector<Scale>{"by", &Scale::by, "1", within(0.001, 1000), required,
                                    "Factors along x, y and z."},
                      Position<Scale>{"pivot", &Scale::pivot, Vec3{}, "The point that stays."}};
  }
  Support support(std::span<const Support> children) const {
    return transformed_support(*this, children[0], 1 / shrink());
  }
  Matrix inward() const { return {{{1 / by.x, 0, 0}, {0, 1 / by.y, 0}, {0, 0, 1 / by.z}}}; }
  Vec3 to_child(const Vec3& p) const { return pivot.value + inward() * (p - pivot.value); }
  Vec3 from_child(const Vec3& p) const {
    const Vec3 d = p - pivot.value;
    return pivot.value + Vec3{d.x * by.x, d.y * by.y, d.z * by.z};
  }
  /// A thickness t [m] of the child is at least t times this.
  double shrink() const { return std::min({by.x, by.y, by.z}); }
  friend bool operator==(const Scale&, const Scale&) = default;
};

}  // namespace hoodoo::tree
