#pragma once
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// A number that may be anything in a closed range, for evaluating the geometry of a primitive over
/// a box. A comparison that is not the same throughout, or a division by what may be 0, is decided
/// somehow, and noted: what came of it bounds nothing.
struct Uncertain {
  double low = 0, high = 0;

  Uncertain() = default;
  Uncertain(double v) : low(v), high(v) {}  // NOLINT(google-explicit-constructor): a constant
  Uncertain(double l, double h) : low(l), high(h) {}
  double middle() const { return 0.5 * (low + high); }
  double half() const { return 0.5 * (high - low); }

  /// A comparison since the last call was undecided. Of this thread.
  static bool was_undecided() { return std::exchange(undecided(), false); }
  static void note_undecided() { undecided() = true; }

 private:
  static bool& undecided() {
    thread_local bool any = false;
    return any;
  }
};

inline Uncertain operator+(const Uncertain& a, const Uncertain& b) {
  return {a.low + b.low, a.high + b.high};
}
inline Uncertain operator-(const Uncertain& a, const Uncertain& b) {
  return {a.low - b.high, a.high - b.low};
}
inline Uncertain operator-(const Uncertain& a) { return {-a.high, -a.low}; }
inline Uncertain operator*(const Uncertain& a, const Uncertain& b) {
  if (&a == &b) {  // a square
    const double l = a.low * a.low, h = a.high * a.high;
    return {a.low <= 0 && a.high >= 0 ? 0 : std::min(l, h), std::max(l, h)};
  }
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, t = a.high * b.high;
  return {std::min({p, q, r, t}), std::max({p, q, r, t})};
}
inline Uncertain operator/(const Uncertain& a, const Uncertain& b) {
  if (b.low <= 0 && b.high >= 0) {
    Uncertain::note_undecided();
    return a;
  }
  return a * Uncertain(1 / b.high, 1 / b.low);
}

inline bool operator<(const Uncertain& a, const Uncertain& b) {
  if (a.high < b.low) return true;
  if (a.low >= b.high) return false;
  Uncertain::note_undecided();
  return a.middle() < b.middle();
}
inline bool operator>(const Uncertain& a, const Uncertain& b) { return b < a; }
inline bool operator<=(const Uncertain& a, const Uncertain& b) { return !(b < a); }
inline bool operator>=(const Uncertain& a, const Uncertain& b) { return !(a < b); }

inline Uncertain value_of(const Uncertain& v) { return v; }
inline Uncertain square_root(const Uncertain& a) {
  return {std::sqrt(std::max(a.low, 0.0)), std::sqrt(std::max(a.high, 0.0))};
}
inline Uncertain smaller(const Uncertain& a, const Uncertain& b) {
  return {std::min(a.low, b.low), std::min(a.high, b.high)};
}
inline Uncertain larger(const Uncertain& a, const Uncertain& b) {
  return {std::max(a.low, b.low), std::max(a.high, b.high)};
}
inline Uncertain clamped(const Uncertain& a, double low, double high) {
  return {std::clamp(a.low, low, high), std::clamp(a.high, low, high)};
}
inline Uncertain magnitude(const Uncertain& a) {
  const double l = std::abs(a.low), h = std::abs(a.high);
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(l, h), std::max(l, h)};
}
inline Uncertain hull(const Uncertain& a, const Uncertain& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}
inline Projection<Uncertain> hull(const Projection<Uncertain>& a, const Projection<Uncertain>& b) {
  return {hull(a.distance, b.distance), hull(a.x, b.x), hull(a.y, b.y), hull(a.z, b.z)};
}

/// Of a shape seen over a box: a distance changes by no more than one metre per metre.
template <class Shape>
Uncertain distance_over(const Shape& shape, const Uncertain& x, const Uncertain& y,
                        const Uncertain& z) {
  const double off = length(Vec3{x.half(), y.half(), z.half()});
  const double d = shape.template project<double>(x.middle(), y.middle(), z.middle()).distance;
  return {d - off, d + off};
}

}  // namespace hoodoo::tree
