#pragma once
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// The child's image in a plane: F(p) = F_1(p - 2 n (n . (p - point))).
struct Mirror {
  static constexpr std::string_view type = "mirror";
  static constexpr std::string_view doc =
      "The child's image in a plane: F(p) = F_1(p - 2 n (n . (p - point))).";
  static constexpr std::string_view cited = "hoodoo";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is mirrored.", 1, 1, false}};
  static constexpr bool rigid = true;

  Point point;
  Vec3 normal{1, 0, 0};

  static constexpr auto fields() {
    return std::tuple{
        Position<Mirror>{"point", &Mirror::point, Vec3{}, "A point of the plane."},
        Direction<Mirror>{"normal", &Mirror::normal, required, "Perpendicular to the plane."}};
  }
  Support support(std::span<const Support> children) const {
    return transformed_support(*this, children[0], 1);
  }
  Matrix inward() const {
    const Vec3 n = normalized(normal);
    Matrix m = unit_matrix;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        m[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] -= 2 * n[r] * n[c];
      }
    }
    return m;
  }
  Vec3 to_child(const Vec3& p) const { return point.value + inward() * (p - point.value); }
  Vec3 from_child(const Vec3& p) const { return to_child(p); }
  double shrink() const { return 1; }
  friend bool operator==(const Mirror&, const Mirror&) = default;
};

}  // namespace hoodoo::tree
