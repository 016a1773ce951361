#pragma once
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// The child, moved: F(p) = F_1(p - by).
struct Translate {
  static constexpr std::string_view type = "translate";
  static constexpr std::string_view doc = "The child, moved: F(p) = F_1(p - by).";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is moved.", 1, 1, false}};
  static constexpr bool rigid = true;

  Vec3 by;  // [m]

  static constexpr auto fields() {
    return std::tuple{Vector<Translate>{"by", &Translate::by, "m", within(-farthest, farthest),
                                        required, "How far, along x, y and z."}};
  }
  Support support(std::span<const Support> children) const {
    return transformed_support(*this, children[0], 1);
  }
  Matrix inward() const { return unit_matrix; }
  Vec3 to_child(const Vec3& p) const { return p - by; }
  Vec3 from_child(const Vec3& p) const { return p + by; }
  double shrink() const { return 1; }
  friend bool operator==(const Translate&, const Translate&) = default;
};

}  // namespace hoodoo::tree
