#pragma once
#include <span>
#include <vector>

#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// The stretch of an axis along which a deformation grows from nothing at `center` to all of it at
/// center + length * axis; beyond both ends it stays as it is there.
struct Spine {
  Point center;
  Vec3 axis{0, 0, 1};
  double length = 1;  // [m]
  friend bool operator==(const Spine&, const Spine&) = default;
};

template <class N>
constexpr auto spine_fields() {
  return std::tuple{
      Position<N>{"center", &N::center, required, "Where it starts; a point of the axis."},
      Direction<N>{"axis", &N::axis, Vec3{0, 0, 1}, "Direction of the axis."},
      Number<N>{"length", &N::length, "m", within(0.001, longest), required,
                "Along the axis, from no deformation to all of it."}};
}

inline constexpr std::array deformation_slots{
    Slot{"child", "What is deformed.", 1, 1, false},
    Slot{"control", "fD: where and how much, in [0,1]; everywhere without it.", 0, 1, false}};

/// A point seen from a spine, in numbers S relative to a block.
template <class S>
struct LocalSpine {
  S cx, cy, cz, ax, ay, az, per_length;

  LocalSpine(const Spine& spine, const Vec3& origin) {
    const Vec3 c = spine.center.value - origin, a = normalized(spine.axis);
    cx = static_cast<S>(c.x);
    cy = static_cast<S>(c.y);
    cz = static_cast<S>(c.z);
    ax = static_cast<S>(a.x);
    ay = static_cast<S>(a.y);
    az = static_cast<S>(a.z);
    per_length = static_cast<S>(1 / spine.length);
  }
  /// How much of the deformation there is, in [0,1], and the way from the axis to the point.
  template <class T>
  struct Place {
    T grown, x, y, z;
  };
  template <class T>
  Place<T> place(const T& px, const T& py, const T& pz) const {
    const T dx = px - cx, dy = py - cy, dz = pz - cz;
    const T h = dx * ax + dy * ay + dz * az;
    return {clamped(h * per_length, S(0), S(1)), dx - h * ax, dy - h * ay, dz - h * az};
  }
};

/// `box` stretched across the axis by `factor`; everywhere when a side is infinite.
Box stretched(const Spine& spine, const Box& box, double factor);
/// `box` turned about the axis by every angle; everywhere when a side is infinite.
Box revolved(const Spine& spine, const Box& box);
/// The largest distance of the box's points from the axis.
double farthest_from(const Spine& spine, const Box& box);

/// How fast a deformation moves what lies `away` [m] from its axis: at most `stretch` plus away *
/// per_metre metres per metre, and away * per_control metres from no control field to all of it.
struct Bend {
  double stretch, per_metre, per_control;
};

/// The linear bound on how a deformation steepens its child: `stretch` along the child's
/// influence, plus what `bend` [1/m] and the control field add at its farthest point.
double steepened(double slope, double stretch, double away, double bend);

}  // namespace hoodoo::tree
