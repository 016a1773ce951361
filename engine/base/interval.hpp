#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace hoodoo {

/// A closed range of values. Arithmetic on it is conservative up to rounding; whoever decides
/// something by a bound first widens it by `outward`.
struct Interval {
  double low = 0, high = 0;

  static Interval everything() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
  bool contains(double v) const { return v >= low && v <= high; }
  double width() const { return high - low; }
  friend bool operator==(const Interval&, const Interval&) = default;
};

inline Interval operator+(const Interval& a, const Interval& b) {
  return {a.low + b.low, a.high + b.high};
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return {a.low - b.high, a.high - b.low};
}
inline Interval operator*(const Interval& a, double s) {
  return s >= 0 ? Interval{a.low * s, a.high * s} : Interval{a.high * s, a.low * s};
}
inline Interval operator*(const Interval& a, const Interval& b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, t = a.high * b.high;
  return {std::min({p, q, r, t}), std::max({p, q, r, t})};
}
inline Interval min(const Interval& a, const Interval& b) {
  return {std::min(a.low, b.low), std::min(a.high, b.high)};
}
inline Interval max(const Interval& a, const Interval& b) {
  return {std::max(a.low, b.low), std::max(a.high, b.high)};
}
inline Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}
inline Interval clamp(const Interval& a, double low, double high) {
  return {std::clamp(a.low, low, high), std::clamp(a.high, low, high)};
}
inline Interval square(const Interval& a) {
  const double l = a.low * a.low, h = a.high * a.high;
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(l, h), std::max(l, h)};
}

/// `a` widened by more than single precision can have lost in a short chain of operations.
inline Interval outward(const Interval& a) {
  const double slack = 1e-5 * (1 + std::max(std::abs(a.low), std::abs(a.high)));
  return {a.low - slack, a.high + slack};
}

}  // namespace hoodoo
