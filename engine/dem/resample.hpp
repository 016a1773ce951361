#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/dem/dem.hpp"
#include "engine/dem/source_map.hpp"

namespace hoodoo::dem {

/// What level 0 of a raster in a frame is made of.
struct Recipe {
  RasterInfo info;
  Frame frame;
  std::optional<double> fill;  // [m]
  bool copied = false;         // the samples themselves; else one bicubic resampling
  Pyramid::Level grid{};       // in the scene frame
};

/// `pixel` [m] is the size of the pixels where the raster is resampled.
/// Errors: bad_input, limit.
Recipe recipe(const RasterInfo& info, const Frame& frame, double pixel, std::optional<double> fill);

/// Makes pixels of level 0. One object per thread; every pixel depends on the recipe and the file
/// alone, not on what was asked before.
class Resampler {
 public:
  Resampler(std::unique_ptr<Raster> raster, const Recipe& recipe);

  /// Pixels [i0, i0 + width) x [j0, j0 + height) of the grid, from the south, `stride` apart from
  /// row to row. What lies outside the grid is left as it was. Errors: io, bad_input.
  void make(std::int64_t i0, std::int64_t j0, int width, int height, float* out, int stride);

 private:
  void copy(std::int64_t i0, std::int64_t j0, int width, int height, float* out, int stride);
  void interpolate(std::int64_t i0, std::int64_t j0, int width, int height, float* out, int stride);
  bool fetch(const std::vector<Point>& points);
  float value(const Point& p) const;

  std::unique_ptr<Raster> raster_;
  Recipe recipe_;
  SourceMap map_;
  std::vector<double> samples_;  // of the file [m], NaN where there is none
  std::int64_t left_ = 0, top_ = 0;
  std::int64_t columns_ = 0, rows_ = 0;
  std::vector<double> read_;
};

}  // namespace hoodoo::dem
