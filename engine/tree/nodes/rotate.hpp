#pragma once
#include "engine/base/math.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// The child, turned about an axis through a pivot, counter-clockwise seen against the axis:
/// F(p) = F_1(pivot + Q^-1 (p - pivot)), Q by Rodrigues' formula.
struct Rotate {
  static constexpr std::string_view type = "rotate";
  static constexpr std::string_view doc =
      "The child, turned about an axis through a pivot, counter-clockwise seen against the axis.";
  static constexpr std::string_view cited = "Rodrigues' formula";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is turned.", 1, 1, false}};
  static constexpr bool rigid = true;

  Vec3 axis{0, 0, 1};
  double angle = 0;  // [deg]
  Point pivot;

  static constexpr auto fields() {
    return std::tuple{
        Direction<Rotate>{"axis", &Rotate::axis, Vec3{0, 0, 1}, "Direction of the axis."},
        Number<Rotate>{"angle", &Rotate::angle, "deg", within(-360, 360), required,
                       "How far it is turned."},
        Position<Rotate>{"pivot", &Rotate::pivot, Vec3{}, "A point of the axis."}};
  }
  Support support(std::span<const Support> children) const {
    return transformed_support(*this, children[0], 1);
  }
  /// Q for `degrees`.
  Matrix turn(double degrees) const {
    const double radians = degrees * (pi / 180), s = bit_sin(radians), c = bit_cos(radians);
    const Vec3 a = normalized(axis);
    const double k = 1 - c;
    return {{{c + k * a.x * a.x, k * a.x * a.y - s * a.z, k * a.x * a.z + s * a.y},
             {k * a.y * a.x + s * a.z, c + k * a.y * a.y, k * a.y * a.z - s * a.x},
             {k * a.z * a.x - s * a.y, k * a.z * a.y + s * a.x, c + k * a.z * a.z}}};
  }
  Matrix inward() const { return turn(-angle); }
  Vec3 to_child(const Vec3& p) const { return pivot.value + inward() * (p - pivot.value); }
  Vec3 from_child(const Vec3& p) const { return pivot.value + turn(angle) * (p - pivot.value); }
  double shrink() const { return 1; }
  friend bool operator==(const Rotate&, const Rotate&) = default;
};

}  // namespace hoodoo::tree
