#pragma once
#include <array>
#include <cstdint>
#include <span>

namespace hoodoo::slice {

/// A number each of several points.
struct Along {
  std::span<double> x, y, z;
};
struct ConstAlong {
  std::span<const double> x, y, z;
};

/// Points counted from `origin`, in steps of `step` [m]: where they lie [m].
void to_metres(std::span<const std::array<std::int32_t, 3>> points,
               const std::array<double, 3>& origin, double step, const Along& out);

/// Newton's steps: gradient times -above / |gradient|^2, 0 where there is no gradient.
void newton_steps(std::span<const double> above, const ConstAlong& gradient, const Along& out);

}  // namespace hoodoo::slice
