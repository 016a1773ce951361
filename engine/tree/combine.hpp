#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <tuple>

#include "engine/tree/dual.hpp"
#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

/// Whether the value of a combiner is always one of its children's terms, and which. A child whose
/// term another's beats throughout a block is left out there.
enum class Pick { none, largest, smallest };

/// Support of an operator whose value is one of its children's.
template <class Join>
Support hull_of(std::span<const Support> children, Join join) {
  Support all = children[0];
  for (const Support& c : children.subspan(1)) {
    all.influence.add(c.influence);
    all.range = join(all.range, c.range);
    all.slope = std::max(all.slope, c.slope);
  }
  return all;
}

/// Support of min(F_1, 1 - F_2, ...): outside the first child's it is 0, unless another exceeds 1.
inline Support difference_support(std::span<const Support> children) {
  Support all = children[0];
  for (const Support& c : children.subspan(1)) {
    const Interval rest = Interval{1, 1} - c.range;
    if (rest.low < 0) all.influence.add(c.influence);
    all.range = min(all.range, rest);
    all.slope = std::max(all.slope, c.slope);
  }
  return all;
}

/// Fillet between a and b: m^2 / (4 w), m = max(0, w - |a - b|), w = width max(0, a + b).
///
/// The polynomial smooth maximum (Quilez 2013) with its width in proportion to a + b, which is 1 at
/// a surface. So two zeros stay 0 and the support stays compact, and a child that is 0 changes
/// nothing. max(a, b) + fillet grows with a and with b; |df/da| + |df/db| <= 1 + width / 2.
template <class T>
T fillet(const T& a, const T& b, double width) {
  const T zero = constant<T>(0);
  const T w = constant<T>(width) * larger(zero, a + b);
  const T m = larger(zero, w - magnitude(a - b));
  return (m * m) / (constant<T>(4) * larger(w, constant<T>(1e-30)));
}

}  // namespace hoodoo::tree
