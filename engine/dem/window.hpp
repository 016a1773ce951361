#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"

namespace hoodoo::dem {

/// Elevation [m] and its slope [1] at a point.
struct Height {
  double h, hx, hy;
};

/// A rectangle of one pyramid level's samples, evaluated by cubic convolution (Keys 1981,
/// a = -1/2: it passes through the samples and reproduces quadratics) with its exact gradient.
/// Beside NoData, the nearest valid sample continues outward. All arithmetic in double, multiply
/// and add only; the value at (x, y) is the same bits whichever window holds it.
class Window {
 public:
  Window() = default;
  /// `samples` row by row from the south, NaN where there is none; pixel (0,0) of the window is
  /// pixel (i0, j0) of the level. Fills what lies within 4 pixels of a valid sample.
  Window(double x0, double y0, double dx, double dy, std::int64_t i0, std::int64_t j0, int width,
         int height, std::vector<float> samples);

  bool empty() const { return filled_.empty(); }
  /// The pixel holding (x, y) is valid.
  bool valid(double x, double y) const;
  /// x, y in the scene frame [m]. Outside the window the edge continues. Where no valid sample is
  /// near, h is 0.
  Height at(double x, double y) const;
  /// Elevation alone: the same bits as at().h.
  double height(double x, double y) const;
  /// Contains height(x, y) for every (x, y) in `area`.
  Interval bounds(const Box& area) const;
  /// Bound on |grad h| over `area`.
  double slope(const Box& area) const;

 private:
  double x0_ = 0, y0_ = 0, dx_ = 1, dy_ = 1;  // of the level's pixel (0,0)
  std::int64_t i0_ = 0, j0_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<float> filled_;
  std::vector<bool> valid_;
};

}  // namespace hoodoo::dem
