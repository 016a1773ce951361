#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/dem/footprint.hpp"

namespace hoodoo::dem {

/// From the pixels of a level-0 grid to pixel coordinates of the file. One object per thread.
///
/// PROJ's results end in the C library's rounding, which differs between machines, and no byte may.
/// So PROJ is asked only at the corners of patches of 64 x 64 pixels, anchored at the grid's pixel
/// (0, 0), and its answers are rounded to 2^-8 of a source pixel, some 10^8 times the noise.
/// Between the corners goes a cubic through 4 x 4 of them (Lagrange). Off PROJ by less than a
/// hundredth of a source pixel: at most 1.56 x 2^-9 by rounding; the cubic's own error is checked
/// at every patch's centre, and a patch that fails (near a pole, across the date line) is mapped
/// pixel by pixel, rounded alike.
class SourceMap {
 public:
  static constexpr int patch = 64;

  /// `grid` in the scene frame, square or not. Errors as `mapping`.
  SourceMap(const RasterInfo& info, const Frame& frame, const Pyramid::Level& grid);

  /// Pixel coordinates (corner of the first pixel = 0, 0) of the centres of the grid's pixels
  /// [i0, i0 + width) x [j0, j0 + height), which lie inside one patch; NaN where there is none.
  void map(std::int64_t i0, std::int64_t j0, int width, int height, std::vector<Point>& out);

  /// One point of the grid (in its pixels, corner = 0, 0) straight through PROJ, not rounded.
  Point exact(double i, double j) const;

 private:
  struct Corners {
    std::int64_t column, row;
    bool smooth;
    std::array<Point, 16> points;
    // The cubics through the columns of points at j, and across those at i; both in pixels from the
    // patch's corner.
    std::array<Point, 4> columns_at(double j) const;
    static Point at(const std::array<Point, 4>& columns, double i);
  };
  const Corners& corners(std::int64_t column, std::int64_t row);
  Point source_pixel(Point p) const;

  RasterInfo info_;
  Frame frame_;
  Pyramid::Level grid_;
  std::optional<Mapping> mapping_;
  double middle_longitude_ = 0;
  std::array<double, 4> inverse_{};  // of the transform's matrix
  std::optional<Corners> last_;
};

}  // namespace hoodoo::dem
