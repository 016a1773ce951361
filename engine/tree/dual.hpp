#pragma once
#include <algorithm>
#include <cmath>

#include "engine/base/interval.hpp"

namespace hoodoo::tree {

/// A number with its gradient in space: forward differentiation. The value part runs the very
/// operations that plain S would, so both give the same bits.
template <class S>
struct Dual {
  S v{}, x{}, y{}, z{};

  Dual() = default;
  Dual(S value) : v(value) {}  // NOLINT(google-explicit-constructor): a constant has gradient 0
  Dual(S value, S gx, S gy, S gz) : v(value), x(gx), y(gy), z(gz) {}
};

template <class S>
Dual<S> operator+(const Dual<S>& a, const Dual<S>& b) {
  return {a.v + b.v, a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class S>
Dual<S> operator-(const Dual<S>& a, const Dual<S>& b) {
  return {a.v - b.v, a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S>
Dual<S> operator-(const Dual<S>& a) {
  return {-a.v, -a.x, -a.y, -a.z};
}
template <class S>
Dual<S> operator*(const Dual<S>& a, const Dual<S>& b) {
  return {a.v * b.v, a.v * b.x + b.v * a.x, a.v * b.y + b.v * a.y, a.v * b.z + b.v * a.z};
}
template <class S>
Dual<S> operator/(const Dual<S>& a, const Dual<S>& b) {
  const S q = a.v / b.v;
  return {q, (a.x - q * b.x) / b.v, (a.y - q * b.y) / b.v, (a.z - q * b.z) / b.v};
}
template <class S>
Dual<S> operator+(const Dual<S>& a, S b) {
  return {a.v + b, a.x, a.y, a.z};
}
template <class S>
Dual<S> operator-(const Dual<S>& a, S b) {
  return {a.v - b, a.x, a.y, a.z};
}
template <class S>
Dual<S> operator+(S a, const Dual<S>& b) {
  return {a + b.v, b.x, b.y, b.z};
}
template <class S>
Dual<S> operator-(S a, const Dual<S>& b) {
  return {a - b.v, -b.x, -b.y, -b.z};
}
template <class S>
Dual<S> operator*(const Dual<S>& a, S b) {
  return {a.v * b, a.x * b, a.y * b, a.z * b};
}
template <class S>
Dual<S> operator*(S a, const Dual<S>& b) {
  return {a * b.v, a * b.x, a * b.y, a * b.z};
}

inline float value_of(float v) { return v; }
inline double value_of(double v) { return v; }
template <class S>
S value_of(const Dual<S>& v) {
  return v.v;
}

/// The type of a T's value.
template <class T>
using Scalar = decltype(value_of(T{}));

inline float square_root(float v) { return std::sqrt(v); }
inline double square_root(double v) { return std::sqrt(v); }
/// At 0, where the root has no slope, the gradient is taken as 0.
template <class S>
Dual<S> square_root(const Dual<S>& a) {
  const S r = std::sqrt(a.v);
  const S f = r > S(0) ? S(0.5) / r : S(0);
  return {r, a.x * f, a.y * f, a.z * f};
}

/// `a` where the two are equal.
template <class T>
T smaller(const T& a, const T& b) {
  return value_of(b) < value_of(a) ? b : a;
}
template <class T>
T larger(const T& a, const T& b) {
  return value_of(b) > value_of(a) ? b : a;
}
inline Interval smaller(const Interval& a, const Interval& b) { return min(a, b); }
inline Interval larger(const Interval& a, const Interval& b) { return max(a, b); }

template <class T>
T clamped(const T& a, Scalar<T> low, Scalar<T> high) {
  return smaller(larger(a, T(low)), T(high));
}
inline Interval clamped(const Interval& a, double low, double high) { return clamp(a, low, high); }

template <class T>
T magnitude(const T& a) {
  return value_of(a) < Scalar<T>(0) ? -a : a;
}
inline Interval magnitude(const Interval& a) {
  const double l = std::abs(a.low), h = std::abs(a.high);
  return {a.low <= 0 && a.high >= 0 ? 0 : std::min(l, h), std::max(l, h)};
}

template <class T>
T squared(const T& a) {
  return a * a;
}
inline Interval squared(const Interval& a) { return square(a); }

/// A constant as a T.
template <class T>
T constant(double c) {
  return T(static_cast<Scalar<T>>(c));
}
template <>
inline Interval constant<Interval>(double c) {
  return {c, c};
}

}  // namespace hoodoo::tree
