#pragma once
#include "engine/base/math.hpp"
#include "engine/tree/deform.hpp"
#include "engine/tree/functions.hpp"

namespace hoodoo::tree {

/// The child, twisted about an axis: turned by angle u fD(p), u from 0 at the centre to 1 at its
/// end, counter-clockwise seen against the axis. The control field scales the angle, so that a
/// point keeps its distance from the axis. Source: Barr 1984, Global and local deformations of
/// solid primitives, section 5; localised as Paris et al. 2019, section 5.3.
struct Twist : Spine {
  static constexpr std::string_view type = "twist";
  static constexpr std::string_view doc =
      "The child, turned about an axis by an angle that grows along it.";
  static constexpr std::string_view cited =
      "Barr 1984, Global and local deformations of solid primitives, section 5";
  static constexpr Family family = Family::any;
  static constexpr auto slots = deformation_slots;

  double angle = 0;  // [deg]

  static constexpr auto fields() {
    return std::tuple_cat(
        spine_fields<Twist>(),
        std::tuple{Number<Twist>{"angle", &Twist::angle, "deg", within(-3600, 3600), required,
                                 "How far the end is turned."}});
  }
  double shrink() const { return 1; }
  Support support(std::span<const Support> children) const;
  /// Where the child is seen from the points of a box.
  Box source(const Box& box) const { return revolved(*this, box); }
  Bend bend() const;

  template <class S>
  struct Map {
    LocalSpine<S> spine;
    S turn;  // [rad]

    /// Moves a point; w is the control field.
    template <class T>
    void operator()(T& x, T& y, T& z, const T& w) const {
      const auto p = spine.place(x, y, z);
      const T a = p.grown * w * turn;
      const T c = cosine(a) - S(1), s = sine(a);
      // e cos a - (axis x e) sin a: turned back.
      const T qx = p.z * spine.ay - p.y * spine.az, qy = p.x * spine.az - p.z * spine.ax,
              qz = p.y * spine.ax - p.x * spine.ay;
      x = x + (p.x * c - qx * s);
      y = y + (p.y * c - qy * s);
      z = z + (p.z * c - qz * s);
    }
  };
  template <class S>
  Map<S> map(const Vec3& origin) const {
    return {{*this, origin}, static_cast<S>(angle * (pi / 180))};
  }
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const Twist&, const Twist&) = default;
};

}  // namespace hoodoo::tree
