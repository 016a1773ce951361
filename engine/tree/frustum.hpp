#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "engine/tree/skeleton.hpp"
#include "engine/tree/uncertain.hpp"

namespace hoodoo::tree {

/// A point in the half plane of an axis, q from it and h along it, and the square of how far it is
/// from what is looked at.
struct ProfilePoint {
  Uncertain square, q, h;
};

/// All that may be the nearest.
inline ProfilePoint nearest_of(std::initializer_list<ProfilePoint> points) {
  const auto nearest =
      std::min(points, [](const auto& a, const auto& b) { return a.square.high < b.square.high; });
  ProfilePoint all = nearest;
  for (const ProfilePoint& p : points) {
    if (p.square.low > nearest.square.high) continue;
    all = {all.square, hull(all.q, p.q), hull(all.h, p.h)};
  }
  return all;
}

/// `v` of an axis's points, turned to where (ex, ey, ez), q long, leads away from it.
template <class Shape>
Projection<Uncertain> turned(const Shape& s, const ProfilePoint& v, const Uncertain& q,
                             const std::array<Uncertain, 3>& e, const Uncertain& distance) {
  const Uncertain f = v.q / larger(q, Uncertain(1e-12));
  const auto across = [&](const Uncertain& along) {
    return clamped(f * along, -std::abs(v.q.high), std::abs(v.q.high));
  };
  return {distance, s.x + v.h * s.ax + across(e[0]), s.y + v.h * s.ay + across(e[1]),
          s.z + v.h * s.az + across(e[2])};
}

/// A solid of revolution between two discs. Its distance is exact: that of (q, h) to the trapezium
/// (0, 0), (r0, 0), (r1, height), (0, height), q the distance to the axis and h along it.
template <class S>
struct Frustum {
  S x, y, z, ax, ay, az;            // centre of the base, unit axis to the top
  S r0, r1, height, slant, nr, nh;  // slant: length of the mantle's side, (nr, nh) its normal

  template <class T>
  Projection<T> project(const T& px, const T& py, const T& pz) const {
    const T dx = px - x, dy = py - y, dz = pz - z;
    const T h = dx * ax + dy * ay + dz * az;
    const T ex = dx - h * ax, ey = dy - h * ay, ez = dz - h * az;
    const T q = square_root(ex * ex + ey * ey + ez * ez);
    const T mantle = (q - r0) * nr + h * nh;              // signed distance to its line
    const T along = (h * nr - (q - r0) * nh) / T(slant);  // 0 at the base's rim, 1 at the top's
    const T t = clamped(along, S(0), S(1));
    const bool inside = value_of(mantle) <= S(0) && value_of(h) >= S(0) && value_of(h) <= height;
    // The nearest point of each side.
    const T mq = r0 + t * (r1 - r0), mh = t * height;
    const T bq = smaller(q, T(r0)), tq = smaller(q, T(r1));
    const T m2 = (q - mq) * (q - mq) + (h - mh) * (h - mh);
    const T b2 = (q - bq) * (q - bq) + h * h;
    const T t2 = (q - tq) * (q - tq) + (h - height) * (h - height);
    const auto away = [&](const T& d2) { return inside ? -square_root(d2) : square_root(d2); };
    T d, vq, vh;
    if (value_of(m2) < value_of(b2) && value_of(m2) < value_of(t2)) {
      const bool face = value_of(along) > S(0) && value_of(along) < S(1);
      d = face ? mantle : away(m2);
      vq = mq;
      vh = mh;
    } else if (value_of(b2) <= value_of(t2)) {
      d = value_of(q) <= r0 ? -h : away(b2);
      vq = bq;
      vh = T(S(0));
    } else {
      d = value_of(q) <= r1 ? h - height : away(t2);
      vq = tq;
      vh = T(height);
    }
    const T f = vq / larger(q, T(S(1e-12)));
    return {d, x + vh * ax + f * ex, y + vh * ay + f * ey, z + vh * az + f * ez};
  }
  Projection<Uncertain> project(const Uncertain& px, const Uncertain& py,
                                const Uncertain& pz) const {
    const Uncertain dx = px - x, dy = py - y, dz = pz - z;
    const Uncertain h = dx * ax + dy * ay + dz * az;
    const Uncertain ex = dx - h * ax, ey = dy - h * ay, ez = dz - h * az;
    const Uncertain q = square_root(ex * ex + ey * ey + ez * ez);
    const Uncertain t = clamped((h * nr - (q - r0) * nh) / Uncertain(slant), 0, 1);
    const auto point = [&](const Uncertain& vq, const Uncertain& vh) {
      const Uncertain across = q - vq, up = h - vh;
      return ProfilePoint{across * across + up * up, vq, vh};
    };
    const auto nearest =
        nearest_of({point(r0 + t * (r1 - r0), t * height), point(smaller(q, Uncertain(r0)), 0),
                    point(smaller(q, Uncertain(r1)), height)});
    return turned(*this, nearest, q, {ex, ey, ez}, distance_over(*this, px, py, pz));
  }
};

template <class S>
Frustum<S> frustum_between(const Vec3& base, const Vec3& top, double r0, double r1) {
  const Vec3 u = top - base, a = normalized(u);
  const double h = length(u), slant = std::max(std::sqrt(h * h + (r0 - r1) * (r0 - r1)), 1e-30);
  const auto s = [](double v) { return static_cast<S>(v); };
  return {s(base.x), s(base.y), s(base.z), s(a.x),   s(a.y),       s(a.z),
          s(r0),     s(r1),     s(h),      s(slant), s(h / slant), s((r0 - r1) / slant)};
}

/// Box of a frustum.
inline Box frustum_box(const Vec3& base, const Vec3& top, double r0, double r1) {
  const Vec3 axis = normalized(top - base);
  const auto across = [](double a) { return std::sqrt(std::max(0.0, 1 - a * a)); };
  const Vec3 disk{across(axis.x), across(axis.y), across(axis.z)};
  Box box{base - disk * r0, base + disk * r0};
  box.add(Box{top - disk * r1, top + disk * r1});
  return box;
}

/// Radius of the largest ball inside a frustum: it touches the wider disc and the mantle, or both
/// discs.
inline double frustum_ball(double height, double r0, double r1) {
  const double wide = std::max(r0, r1), narrow = std::min(r0, r1);
  const double slant = std::sqrt(height * height + (wide - narrow) * (wide - narrow));
  return std::min(height / 2, wide * height / std::max(slant + (wide - narrow), 1e-300));
}

}  // namespace hoodoo::tree
