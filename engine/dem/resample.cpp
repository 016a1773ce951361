#include "engine/dem/resample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/dem/keys.hpp"

namespace hoodoo::dem {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
// More source pixels than this are not held at once for one piece of a patch.
constexpr std::int64_t most_at_once = 1 << 20;

// A stencil of 4 x 4 samples whose NaN are replaced by the nearest other, among equally near ones
// by the first in file order.
void complete(std::array<double, 16>& s) {
  const auto given = s;
  for (int p = 0; p < 16; ++p) {
    const auto at = static_cast<std::size_t>(p);
    if (!std::isnan(given[at])) continue;
    int nearest = 1000;
    for (int q = 0; q < 16; ++q) {
      const int across = p % 4 - q % 4, down = p / 4 - q / 4;
      const int square = across * across + down * down;
      const double other = given[static_cast<std::size_t>(q)];
      if (std::isnan(other) || square >= nearest) continue;
      nearest = square;
      s[at] = other;
    }
  }
}

}  // namespace

Recipe recipe(const RasterInfo& info, const Frame& frame, double pixel,
              std::optional<double> fill) {
  Recipe r{info, frame, fill, aligned(info, frame), {}};
  const auto box = footprint(info, frame);
  if (r.copied) {
    r.grid = {box.min_x - frame.origin_x,
              box.min_y - frame.origin_y,
              std::abs(info.transform[1]) * frame.unit,
              std::abs(info.transform[5]) * frame.unit,
              info.width,
              info.height};
    return r;
  }
  if (!(pixel > 0) || !std::isfinite(pixel)) {
    throw Error(Fault::internal, info.path.string(),
                fmt::format("cannot have pixels of {} m", pixel));
  }
  const double i0 = std::floor((box.min_x - frame.origin_x) / pixel);
  const double j0 = std::floor((box.min_y - frame.origin_y) / pixel);
  const double width = std::ceil((box.max_x - frame.origin_x) / pixel) - i0;
  const double height = std::ceil((box.max_y - frame.origin_y) / pixel) - j0;
  const auto most = static_cast<double>(RasterLimits{}.pixels);
  if (!(width * height <= most)) {
    throw Error(Fault::limit, info.path.string(),
                fmt::format("would take {} x {} pixels of {} m in the scene's frame; the limit is "
                            "{} in all",
                            width, height, pixel, RasterLimits{}.pixels));
  }
  r.grid = {i0 * pixel,
            j0 * pixel,
            pixel,
            pixel,
            std::max<std::int64_t>(1, static_cast<std::int64_t>(width)),
            std::max<std::int64_t>(1, static_cast<std::int64_t>(height))};
  return r;
}

Resampler::Resampler(std::unique_ptr<Raster> raster, const Recipe& recipe)
    : raster_(std::move(raster)), recipe_(recipe), map_(recipe.info, recipe.frame, recipe.grid) {}

void Resampler::make(std::int64_t i0, std::int64_t j0, int width, int height, float* out,
                     int stride) {
  width = static_cast<int>(std::min<std::int64_t>(width, recipe_.grid.width - i0));
  height = static_cast<int>(std::min<std::int64_t>(height, recipe_.grid.height - j0));
  if (width <= 0 || height <= 0) return;
  if (recipe_.copied) return copy(i0, j0, width, height, out, stride);
  constexpr int patch = SourceMap::patch;
  for (auto j = j0; j < j0 + height;) {
    const auto rows = static_cast<int>(std::min((j / patch + 1) * patch, j0 + height) - j);
    for (auto i = i0; i < i0 + width;) {
      const auto columns = static_cast<int>(std::min((i / patch + 1) * patch, i0 + width) - i);
      interpolate(i, j, columns, rows, out + (j - j0) * stride + (i - i0), stride);
      i += columns;
    }
    j += rows;
  }
}

void Resampler::copy(std::int64_t i0, std::int64_t j0, int width, int height, float* out,
                     int stride) {
  const auto& t = recipe_.info.transform;
  const bool east_first = t[1] > 0, north_first = t[5] < 0;
  raster_->read(east_first ? i0 : recipe_.info.width - i0 - width,
                north_first ? recipe_.info.height - j0 - height : j0, width, height, read_);
  for (int j = 0; j < height; ++j) {
    const double* const row =
        read_.data() + std::ptrdiff_t{width} * (north_first ? height - 1 - j : j);
    for (int i = 0; i < width; ++i) {
      const double v = row[east_first ? i : width - 1 - i] * recipe_.info.vertical_unit;
      out[std::ptrdiff_t{j} * stride + i] =
          static_cast<float>(std::isnan(v) && recipe_.fill ? *recipe_.fill : v);
    }
  }
}

// Makes samples_ hold what `points` need; false when they do not fit at once.
bool Resampler::fetch(const std::vector<Point>& points) {
  constexpr auto far = std::numeric_limits<double>::infinity();
  double west = far, east = -far, first = far, last = -far;
  for (const auto& p : points) {
    if (std::isnan(p.x) || std::isnan(p.y)) continue;
    west = std::min(west, p.x);
    east = std::max(east, p.x);
    first = std::min(first, p.y);
    last = std::max(last, p.y);
  }
  const auto width = recipe_.info.width, height = recipe_.info.height;
  columns_ = rows_ = 0;
  if (!(east >= 0 && last >= 0 && west < static_cast<double>(width) &&
        first < static_cast<double>(height))) {
    return true;  // all outside
  }
  const auto pixel = [](double v, std::int64_t size) {
    return static_cast<std::int64_t>(std::floor(std::clamp(v, 0.0, static_cast<double>(size - 1))));
  };
  constexpr int margin = 2;
  left_ = pixel(west, width) - margin;
  top_ = pixel(first, height) - margin;
  columns_ = pixel(east, width) + margin + 1 - left_;
  rows_ = pixel(last, height) + margin + 1 - top_;
  if (columns_ * rows_ > most_at_once && points.size() > 1) return false;
  const auto i0 = std::max<std::int64_t>(0, left_), i1 = std::min(width, left_ + columns_);
  const auto j0 = std::max<std::int64_t>(0, top_), j1 = std::min(height, top_ + rows_);
  raster_->read(i0, j0, static_cast<int>(i1 - i0), static_cast<int>(j1 - j0), read_);
  samples_.assign(static_cast<std::size_t>(columns_ * rows_), nan);
  const double* from = read_.data();
  for (auto j = j0; j < j1; ++j) {
    double* to = samples_.data() + (j - top_) * columns_ + (i0 - left_);
    for (auto i = i0; i < i1; ++i, ++from) {
      const double v = *from * recipe_.info.vertical_unit;
      *to++ = std::isnan(v) && recipe_.fill ? *recipe_.fill : v;
    }
  }
  return true;
}

float Resampler::value(const Point& p) const {
  if (!(p.x >= 0 && p.y >= 0 && p.x < static_cast<double>(recipe_.info.width) &&
        p.y < static_cast<double>(recipe_.info.height))) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const auto at = [&](std::int64_t i, std::int64_t j) {
    return samples_.data() + (j - top_) * columns_ + (i - left_);
  };
  // The pixel that holds the point decides whether there is ground.
  if (std::isnan(*at(static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y)))) {
    return std::numeric_limits<float>::quiet_NaN();
  }
  const double i = std::floor(p.x - 0.5), j = std::floor(p.y - 0.5);
  double wx[4], wy[4], across[4];
  keys_weights(p.x - 0.5 - i, wx);
  keys_weights(p.y - 0.5 - j, wy);
  const double* row = at(static_cast<std::int64_t>(i) - 1, static_cast<std::int64_t>(j) - 1);
  for (int k = 0; k < 4; ++k) across[k] = weighted(wx, row + k * columns_);
  const double h = weighted(wy, across);
  if (!std::isnan(h)) return static_cast<float>(h);
  std::array<double, 16> s{};
  for (int k = 0; k < 16; ++k) s[static_cast<std::size_t>(k)] = row[k / 4 * columns_ + k % 4];
  complete(s);
  for (int k = 0; k < 4; ++k) across[k] = weighted(wx, s.data() + std::ptrdiff_t{4} * k);
  return static_cast<float>(weighted(wy, across));
}

void Resampler::interpolate(std::int64_t i0, std::int64_t j0, int width, int height, float* out,
                            int stride) {
  std::vector<Point> points;
  map_.map(i0, j0, width, height, points);
  if (!fetch(points)) {
    const int left = (width + 1) / 2, low = (height + 1) / 2;
    interpolate(i0, j0, left, low, out, stride);
    if (width > left) interpolate(i0 + left, j0, width - left, low, out + left, stride);
    float* const upper = out + std::ptrdiff_t{low} * stride;
    if (height > low) interpolate(i0, j0 + low, left, height - low, upper, stride);
    if (width > left && height > low) {
      interpolate(i0 + left, j0 + low, width - left, height - low, upper + left, stride);
    }
    return;
  }
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      out[std::ptrdiff_t{j} * stride + i] =
          columns_ ? value(points[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(i)])
                   : std::numeric_limits<float>::quiet_NaN();
    }
  }
}

}  // namespace hoodoo::dem
