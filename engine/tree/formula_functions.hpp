#pragma once
#include <algorithm>
#include <cmath>

#include "engine/tree/formula.hpp"
#include "engine/tree/functions.hpp"

/// The functions of formulas, for double, Dual<double> and Interval; each defined everywhere.
namespace hoodoo::tree::formula {

using D = Dual<double>;

inline constexpr double most = 1e30;
inline constexpr double least_log = 1e-30;

/// Held, so that nothing overflows and no value is no number.
inline double held(double v) { return v >= -most ? std::min(v, most) : -most; }
inline D held(const D& v) { return {held(v.v), held(v.x), held(v.y), held(v.z)}; }
inline Interval held(const Interval& v) { return {held(v.low), held(v.high)}; }

inline constexpr Interval everything{-most, most};

template <class T>
T constant_of(double v) {
  return T(v);
}
template <>
inline Interval constant_of<Interval>(double v) {
  return {v, v};
}

inline double divide(double a, double b) { return b == 0 ? 0 : a / b; }
inline D divide(const D& a, const D& b) { return b.v == 0 ? D(0) : a / b; }
inline Interval divide(const Interval& a, const Interval& b) {
  if (b == Interval{0, 0}) return b;
  if (b.contains(0)) return everything;
  return a * held(Interval{1 / b.high, 1 / b.low});
}

inline double pow(double a, double b) {
  if (a > 0 || b == 0) return bit_pow(std::abs(a), b);
  if (a == 0 || b != std::floor(b)) return 0;
  const double v = bit_pow(-a, b);
  return std::floor(b / 2) * 2 == b ? v : -v;
}
inline D pow(const D& a, const D& b) {
  const double v = held(pow(a.v, b.v));
  const double by_a = b.v == 0 ? 0 : a.v != 0 ? b.v * v / a.v : b.v == 1 ? 1 : 0;
  const double by_b = a.v > 0 ? v * bit_log(a.v) : 0;
  return {v, by_a * a.x + by_b * b.x, by_a * a.y + by_b * b.y, by_a * a.z + by_b * b.z};
}
/// Where it is monotone in both, from the corners.
inline Interval pow(const Interval& a, const Interval& b) {
  const auto corners = [&](double low, double high) {
    const double p = held(pow(low, b.low)), q = held(pow(low, b.high)), r = held(pow(high, b.low)),
                 t = held(pow(high, b.high));
    return Interval{std::min({p, q, r, t}), std::max({p, q, r, t})};
  };
  if (a.low > 0) return corners(a.low, a.high);
  if (b.low != b.high || b.low < 0) return everything;
  if (b.low == 0) return {1, 1};
  const bool whole = b.low == std::floor(b.low), even = std::floor(b.low / 2) * 2 == b.low;
  if (whole && !even) return corners(a.low, a.high);
  const Interval base = whole ? magnitude(a) : larger(a, {0, 0});
  return corners(base.low, base.high);
}

inline double root(double a) { return std::sqrt(std::max(0.0, a)); }
inline D root(const D& a) { return a.v > 0 ? square_root(a) : D(0); }
inline Interval root(const Interval& a) { return {root(a.low), root(a.high)}; }

inline double exponential(double a) { return held(bit_exp(a)); }
inline D exponential(const D& a) {
  const double v = exponential(a.v), slope = v < most ? v : 0;
  return {v, a.x * slope, a.y * slope, a.z * slope};
}
inline Interval exponential(const Interval& a) { return {exponential(a.low), exponential(a.high)}; }

inline double logarithm(double a) { return bit_log(std::max(a, least_log)); }
inline D logarithm(const D& a) {
  const double slope = a.v > least_log ? 1 / a.v : 0;
  return {logarithm(a.v), a.x * slope, a.y * slope, a.z * slope};
}
inline Interval logarithm(const Interval& a) { return {logarithm(a.low), logarithm(a.high)}; }

inline double whole(double a) { return std::floor(a); }
inline D whole(const D& a) { return {std::floor(a.v)}; }
inline Interval whole(const Interval& a) { return {std::floor(a.low), std::floor(a.high)}; }

/// cos over an interval: its extremes lie at whole multiples of pi.
inline Interval cosine(const Interval& a) {
  if (a.width() >= 2 * pi || magnitude(a).high > 1e6) return {-1, 1};
  const double p = tree::cosine(a.low), q = tree::cosine(a.high), slack = 1e-9;
  Interval all{std::min(p, q) - slack, std::max(p, q) + slack};
  const int first = static_cast<int>(std::ceil(a.low / pi - slack));
  const int last = static_cast<int>(std::floor(a.high / pi + slack));
  for (int k = first; k <= last; ++k) {
    if (k % 2 == 0) {
      all.high = 1 + slack;
    } else {
      all.low = -1 - slack;
    }
  }
  return all;
}
inline Interval sine(const Interval& a) { return cosine(a - Interval{pi / 2, pi / 2}); }
inline double cosine(double a) { return tree::cosine(a); }
inline double sine(double a) { return tree::sine(a); }
inline D cosine(const D& a) { return tree::cosine(a); }
inline D sine(const D& a) { return tree::sine(a); }

template <class T>
T smoothstep(const T& a, const T& b, const T& v) {
  const T u = clamped(divide(v - a, b - a), 0.0, 1.0);
  return u * u * (T(3.0) - T(2.0) * u);
}
/// It grows with u.
inline Interval smoothstep(const Interval& a, const Interval& b, const Interval& v) {
  const Interval u = clamped(divide(v - a, b - a), 0.0, 1.0);
  return {u.low * u.low * (3 - 2 * u.low), u.high * u.high * (3 - 2 * u.high)};
}

/// What an instruction makes of its arguments, the last one first.
template <class T>
T result_of(Op op, const T& a) {
  switch (op) {
    case Op::negate:
      return T() - a;
    case Op::abs:
      return magnitude(a);
    case Op::sin:
      return sine(a);
    case Op::cos:
      return cosine(a);
    case Op::sqrt:
      return root(a);
    case Op::exp:
      return exponential(a);
    case Op::log:
      return logarithm(a);
    default:
      return whole(a);
  }
}
template <class T>
T result_of(Op op, const T& a, const T& b) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::subtract:
      return a - b;
    case Op::multiply:
      return a * b;
    case Op::divide:
      return divide(a, b);
    case Op::pow:
      return pow(a, b);
    case Op::min:
      return smaller(a, b);
    default:
      return larger(a, b);
  }
}
template <class T>
T result_of(Op op, const T& a, const T& b, const T& c) {
  switch (op) {
    case Op::clamp:
      return smaller(larger(a, b), c);
    case Op::mix:
      return a + (b - a) * c;
    default:
      return smoothstep(a, b, c);
  }
}

/// How many values an instruction takes from the stack, 4 of noise, which has three.
inline std::size_t arguments(Op op) {
  if (op <= Op::variable) return 0;
  if (op >= Op::add && op <= Op::max) return 2;
  if (op >= Op::clamp && op <= Op::smoothstep) return 3;
  return op >= Op::noise ? 4 : 1;
}

}  // namespace hoodoo::tree::formula
