#pragma once
#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>

#include "engine/tree/node_type.hpp"

namespace hoodoo::tree {

inline constexpr Matrix unit_matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

inline Vec3 operator*(const Matrix& m, const Vec3& v) {
  return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
          m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
          m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

/// Box of the images of `box` under the affine map `to`. An infinite side makes every side that
/// it can reach infinite.
template <class Map>
Box mapped(const Box& box, Map to) {
  if (box.empty()) return box;
  Box image;
  for (int corner = 0; corner < 8; ++corner) {
    const auto pick = [&](int axis) {
      const double v = (corner >> axis & 1) != 0 ? box.max[axis] : box.min[axis];
      return std::clamp(v, -1e30, 1e30);
    };
    image.add(to(Vec3{pick(0), pick(1), pick(2)}));
  }
  // Beyond any coordinate there is: unbounded. Else as much wider as the map may have rounded.
  for (int axis = 0; axis < 3; ++axis) {
    const auto slack = [&](double v) { return 1e-12 * std::abs(v) + 1e-9; };
    double &low = image.min[axis], &high = image.max[axis];
    low = low < -1e20 ? -Box::infinity : low - slack(low);
    high = high > 1e20 ? Box::infinity : high + slack(high);
  }
  return image;
}

template <class N>
Support transformed_support(const N& node, const Support& child, double steeper) {
  return {mapped(child.influence, [&](const Vec3& p) { return node.from_child(p); }), child.range,
          child.slope * steeper};
}

}  // namespace hoodoo::tree
