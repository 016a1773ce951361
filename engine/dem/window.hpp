#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/dem/lookup.hpp"

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
  static constexpr int fill_radius = 4;  // [pixels]

  Window() = default;
  /// `samples` row by row from the south, NaN where there is none; pixel (0,0) of the window is
  /// pixel (i0, j0) of the level. Fills what lies within `fill_radius` of a valid sample.
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
  /// height(x[i], y[i]) of points anywhere, the same bits, found several at a time.
  void heights_at(std::span<const double> x, std::span<const double> y,
                  std::span<double> out) const;
  /// at(x[i], y[i]), likewise.
  struct Heights {
    std::span<double> h, hx, hy;
  };
  void at(std::span<const double> x, std::span<const double> y, const Heights& out) const;
  /// at(x[i], y[j]) into out[x.size() j + i], the same bits: what points in line share is found
  /// once. Without slopes where the spans for them are empty.
  void grid(std::span<const double> x, std::span<const double> y, const Heights& out) const;
  /// valid(x[i], y[j]) into out[x.size() j + i].
  void valid(std::span<const double> x, std::span<const double> y,
             std::span<std::uint8_t> out) const;
  /// Contains height(x, y) for every (x, y) in `area`.
  Interval bounds(const Box& area) const;
  /// Bound on |grad h| over `area`.
  double slope(const Box& area) const;

 private:
  // The four rows of samples around a point, and where it lies between the middle ones.
  struct Stencil {
    double fx, fy;
    const float* rows[4];
    float own[4][4];  // where the window does not hold all sixteen
    const float* row(int k) const { return rows[k] ? rows[k] : own[k]; }
  };
  struct Range {
    int i0, j0, i1, j1;  // closed
  };
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(i);
  }
  Stencil stencil(double x, double y) const;
  void grid_of_few(std::span<const double> x, std::span<const double> y, const Heights& out) const;
  Range involved(const Box& area) const;
  bool is_small() const;
  Samples samples() const;

  double x0_ = 0, y0_ = 0;        // of the level's pixel (0,0)
  double per_x_ = 1, per_y_ = 1;  // pixels per metre
  std::int64_t i0_ = 0, j0_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<float> filled_;
  std::vector<bool> valid_;  // empty: all are
};

/// Contains every interpolation between samples in [low, high].
Interval widened(float low, float high);

}  // namespace hoodoo::dem
