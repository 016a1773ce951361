#pragma once
#include <cstddef>
#include <cstdint>

namespace hoodoo::dem {

/// Where samples lie: what Window knows of itself. `width` times `height` is below 2^31.
struct Samples {
  const float* values;  // row by row from the south
  double x0, y0;        // of the level's pixel (0,0)
  double per_x, per_y;  // pixels per metre
  std::int64_t i0, j0;  // pixel (0,0) of the window
  std::int32_t width, height;
};

/// Elevations at n points, the bits of Window::height, a vector of them at a time. Where `hx` and
/// `hy` are not null they get the slopes, the bits of Window::at.
void look_up(const Samples& samples, const double* x, const double* y, std::size_t n, double* h,
             double* hx, double* hy);

/// The first of four samples around a coordinate, counted from the window's, and the weights of
/// keys.hpp.
struct SamplePlace {
  std::int64_t first;
  double w[4], d[4];
};
/// The same at all points with one of `x` and one of `y`, whose rows lie within `most_rows` of each
/// other: that of (x[i], y[j]) at nx j + i.
inline constexpr std::size_t most_rows = 64;
void look_up_grid(const Samples& samples, const double* x, std::size_t nx, const SamplePlace* y,
                  std::size_t ny, double* h, double* hx, double* hy);

/// Smallest and largest of a closed range of samples.
struct Extremes {
  float low, high;
};
Extremes extremes(const Samples& samples, int i0, int j0, int i1, int j1);

}  // namespace hoodoo::dem
