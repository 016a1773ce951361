#pragma once
#include "engine/tree/deform.hpp"

namespace hoodoo::tree {

/// The child, tapered: its cross-section grows or shrinks along an axis, s = 1 + (factor - 1) u, u
/// from 0 at the centre to 1 at its end; F(p) = F_1(p + e fD(p) (1/s - 1)), e the way from the axis
/// to p. Across level strata it compresses layers. Source: Paris et al. 2019, section 4.3; Barr
/// 1984, Global and local deformations of solid primitives, section 5.
struct Taper : Spine {
  static constexpr std::string_view type = "taper";
  static constexpr std::string_view doc =
      "The child, its cross-section scaled along an axis, from 1 at the centre to a factor at the "
      "end.";
  static constexpr std::string_view cited =
      "Paris et al. 2019, section 4.3; Barr 1984, Global and local deformations of solid "
      "primitives, section 5";
  static constexpr Family family = Family::any;
  static constexpr auto slots = deformation_slots;

  double factor = 1;

  static constexpr auto fields() {
    return std::tuple_cat(
        spine_fields<Taper>(),
        std::tuple{Number<Taper>{"factor", &Taper::factor, "1", within(0.01, 100), required,
                                 "Scale of the cross-section at the end."}});
  }
  /// The extremes of 1 / s.
  Interval inverse() const { return {std::min(1.0, 1 / factor), std::max(1.0, 1 / factor)}; }
  /// A thickness t [m] of the child is at least t times this.
  double shrink() const { return std::min(1.0, factor); }
  Support support(std::span<const Support> children) const;
  /// Where the child is seen from the points of a box.
  Box source(const Box& box) const;
  Bend bend() const;

  template <class S>
  struct Map {
    LocalSpine<S> spine;
    S growth;  // factor - 1

    /// Moves a point; w is the control field.
    template <class T>
    void operator()(T& x, T& y, T& z, const T& w) const {
      const auto p = spine.place(x, y, z);
      const T s = S(1) + p.grown * growth;
      const T by = w * (T(S(1)) / s - S(1));
      x = x + p.x * by;
      y = y + p.y * by;
      z = z + p.z * by;
    }
  };
  template <class S>
  Map<S> map(const Vec3& origin) const {
    return {{*this, origin}, static_cast<S>(factor - 1)};
  }
  Compiled compile_node(const std::vector<Node>& children, const Block& block) const;
  Node prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const;
  friend bool operator==(const Taper&, const Taper&) = default;
};

}  // namespace hoodoo::tree
