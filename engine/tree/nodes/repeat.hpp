#pragma once
#include "engine/base/math.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// Where an instance stands: scaled, turned about the upright through its origin, moved.
struct Placement {
  static constexpr std::string_view type = "placement";

  Point at;
  double angle = 0;  // [deg]
  double scale = 1;

  static constexpr auto fields() {
    using T = Placement;
    return std::tuple{
        Position<T>{"at", &T::at, required, "Where the child's origin comes to lie."},
        Number<T>{"angle", &T::angle, "deg", within(-360, 360), 0.0,
                  "Turned about the upright, counter-clockwise seen from above."},
        Number<T>{"scale", &T::scale, "1", within(0.001, 1000), 1.0, "Scaled about its origin."}};
  }
  /// Turned by `degrees`, then scaled by `factor`.
  static Matrix turned(double degrees, double factor) {
    const double radians = degrees * (pi / 180);
    const double s = factor * bit_sin(radians), c = factor * bit_cos(radians);
    return {{{c, -s, 0}, {s, c, 0}, {0, 0, factor}}};
  }
  Matrix inward() const { return turned(-angle, 1 / scale); }
  Vec3 to_child(const Vec3& p) const { return inward() * (p - at.value); }
  Vec3 from_child(const Vec3& p) const { return at.value + turned(angle, scale) * p; }
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// The child, many times over: F = max(0, F_1, F_2, ...), or the sum, F_i(p) = F_child at p seen
/// from placement i. Source: instances of Paris et al. 2019, section 8.
struct Repeat {
  static constexpr std::string_view type = "repeat";
  static constexpr std::string_view doc =
      "The child, many times over: the union (not below 0) or the sum of its instances.";
  static constexpr std::string_view cited = "Paris et al. 2019, section 8 (instances)";
  static constexpr Family family = Family::any;
  static constexpr std::array slots{Slot{"child", "What is repeated.", 1, 1, false}};

  enum class Join { unite, blend };
  static constexpr std::array<std::string_view, 2> joins{"union", "blend"};

  std::vector<Placement> placements;
  Join join = Join::unite;

  static constexpr auto fields() {
    return std::tuple{Groups<Repeat, Placement>{"placements", &Repeat::placements, 1, 100'000,
                                                "Where it stands."},
                      Choice<Repeat, Join>{"join", &Repeat::join, joins, Join::unite,
                                           "How instances that meet are joined."}};
  }
  Support support(std::span<const Support> children) const;
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const Repeat&, const Repeat&) = default;
};

}  // namespace hoodoo::tree
