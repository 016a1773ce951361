#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>

#include "engine/base/math.hpp"
#include "engine/tree/dual.hpp"

/// Circular functions of numbers and of numbers with gradients: bit-exact, through engine/base.
/// An argument beyond 10^6 is held there.
namespace hoodoo::tree {

template <std::floating_point S>
S sine(S a) {
  return static_cast<S>(bit_sin(std::clamp(static_cast<double>(a), -1e6, 1e6)));
}
template <std::floating_point S>
S cosine(S a) {
  return static_cast<S>(bit_cos(std::clamp(static_cast<double>(a), -1e6, 1e6)));
}
template <class S>
Dual<S> sine(const Dual<S>& a) {
  const S c = std::abs(a.v) < S(1e6) ? cosine(a.v) : S(0);
  return {sine(a.v), a.x * c, a.y * c, a.z * c};
}
template <class S>
Dual<S> cosine(const Dual<S>& a) {
  const S s = std::abs(a.v) < S(1e6) ? -sine(a.v) : S(0);
  return {cosine(a.v), a.x * s, a.y * s, a.z * s};
}

}  // namespace hoodoo::tree
