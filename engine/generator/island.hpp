#pragma once
#include <cstdint>

#include "engine/base/box.hpp"
#include "engine/tree/formula.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

/// A floating island: a height field, another one upside down below it, and a ragged outline, each
/// with the field of a terrain, intersected.
/// Source: Paris et al. 2019, sections 5.1 (two terrains, one inverted) and figure 20.
class Island {
 public:
  /// [m]
  struct Size {
    double radius;  // of the circle that holds it
    double relief;  // of its top
    double rim;     // thickness at its edge
    double depth;   // how much deeper it reaches in the middle, about
    double falloff;
  };
  /// Its rim's upper edge lies at `middle`.
  Island(const Vec3& middle, const Size& size, std::uint64_t key);

  const Vec3& middle() const { return middle_; }
  const Size& size() const { return size_; }
  /// Moves it up or down.
  void rise_to(double z) { middle_.z = z; }

  /// Heights of its upper and lower side; they go on beyond the outline [m].
  double top(double x, double y) const;
  double bottom(double x, double y) const;
  /// How far a place lies inside the outline, about [m].
  double inside(double x, double y) const;
  /// Below its surface; negative outside, about [m].
  double depth(const Vec3& p) const;
  /// Contains all of it.
  Box box() const;
  /// F, 0 well outside the box.
  tree::Node tree() const;
  /// 1 in the box, 0 well outside.
  tree::Node around() const;

 private:
  double value(const tree::Program& program, double x, double y) const;

  Vec3 middle_;
  Size size_;
  std::uint32_t seed_;
  tree::Program top_, bottom_, inside_;  // of (x, y), from the middle
};

}  // namespace hoodoo::generator
