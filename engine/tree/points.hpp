#pragma once
#include <array>
#include <cstddef>
#include <span>

namespace hoodoo::tree {

/// n sample points [m], relative to the origin of the block they belong to. Spans of length n.
/// Runs of equal (x, y) are evaluated faster: order grids with z fastest.
struct Points {
  std::span<const float> x, y, z;
  std::size_t size() const { return x.size(); }
};

/// n gradients [1/m]. Spans of length n.
struct Gradients {
  std::span<float> x, y, z;
};

/// All points with one of `x`, one of `y` and one of `z` [m], relative to the origin of the block
/// they belong to. Their values are listed z fastest, x slowest.
struct Grid {
  std::span<const float> x, y, z;
  std::size_t size() const { return x.size() * y.size() * z.size(); }
};

/// A grid of at most 16 points along each axis as kernels take it: values of point (i, j, k) stand
/// at 256 i + 16 j + k. Rows and planes beyond the counts are evaluated or not, as is convenient:
/// all sixteen coordinates are finite.
struct Cube {
  static constexpr std::size_t side = 16;
  static constexpr std::size_t size = side * side * side;
  alignas(64) std::array<float, side> x, y, z;
  std::size_t nx, ny;
};
using CubeValues = std::span<float, Cube::size>;

}  // namespace hoodoo::tree
