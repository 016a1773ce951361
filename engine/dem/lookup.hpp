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

}  // namespace hoodoo::dem
