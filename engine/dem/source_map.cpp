#include "engine/dem/source_map.hpp"

#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace hoodoo::dem {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Point rounded(const Point& p) {
  return {std::floor(p.x * 256 + 0.5) / 256, std::floor(p.y * 256 + 0.5) / 256};
}

// Weights of the samples at -1, 0, 1, 2 for a point at t.
std::array<double, 4> cubic(double t) {
  const double a = t + 1, b = t, c = t - 1, d = t - 2;
  return {-b * c * d * (1.0 / 6), a * c * d * 0.5, -a * b * d * 0.5, a * b * c * (1.0 / 6)};
}

Point weighted(const std::array<double, 4>& w, const Point& a, const Point& b, const Point& c,
               const Point& d) {
  return {w[0] * a.x + w[1] * b.x + w[2] * c.x + w[3] * d.x,
          w[0] * a.y + w[1] * b.y + w[2] * c.y + w[3] * d.y};
}

}  // namespace

SourceMap::SourceMap(const RasterInfo& info, const Frame& frame, const Pyramid::Level& grid)
    : info_(info), frame_(frame), grid_(grid), mapping_(mapping(info, frame)) {
  const auto& t = info_.transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  inverse_ = {t[5] / determinant, -t[2] / determinant, -t[4] / determinant, t[1] / determinant};
  middle_longitude_ =
      corner(info_, 0.5 * static_cast<double>(info_.width), 0.5 * static_cast<double>(info_.height))
          .x;
}

std::array<Point, 4> SourceMap::Corners::columns_at(double j) const {
  const auto w = cubic(j / patch);
  std::array<Point, 4> columns{};
  for (std::size_t k = 0; k < 4; ++k) {
    columns[k] = weighted(w, points[k], points[4 + k], points[8 + k], points[12 + k]);
  }
  return columns;
}

Point SourceMap::Corners::at(const std::array<Point, 4>& columns, double i) {
  return weighted(cubic(i / patch), columns[0], columns[1], columns[2], columns[3]);
}

Point SourceMap::source_pixel(Point p) const {
  const double x = p.x - info_.transform[0], y = p.y - info_.transform[3];
  return {inverse_[0] * x + inverse_[1] * y, inverse_[2] * x + inverse_[3] * y};
}

Point SourceMap::exact(double i, double j) const {
  const Point place{(grid_.x0 + i * grid_.dx + frame_.origin_x) / frame_.unit,
                    (grid_.y0 + j * grid_.dy + frame_.origin_y) / frame_.unit};
  if (!mapping_) return source_pixel(place);
  auto p = mapping_->inverse(place);
  if (!p) return {nan, nan};
  if (info_.kind == RasterInfo::Crs::geographic) {
    // The turn of longitude nearest the raster.
    p->x += 360 * std::floor((middle_longitude_ - p->x) / 360 + 0.5);
  }
  return source_pixel(*p);
}

const SourceMap::Corners& SourceMap::corners(std::int64_t column, std::int64_t row) {
  if (last_ && last_->column == column && last_->row == row) return *last_;
  Corners c{column, row, true, {}};
  auto* point = c.points.data();
  for (auto l = row - 1; l <= row + 2; ++l) {
    for (auto k = column - 1; k <= column + 2; ++k) {
      *point++ = rounded(exact(static_cast<double>(k * patch), static_cast<double>(l * patch)));
    }
  }
  for (const auto& [i, j] : {std::pair{32, 32}, {12, 12}, {52, 12}, {12, 52}, {52, 52}}) {
    const auto cubed = Corners::at(c.columns_at(j), i);
    const auto direct =
        exact(static_cast<double>(column * patch + i), static_cast<double>(row * patch + j));
    c.smooth =
        c.smooth && std::abs(cubed.x - direct.x) < 0.006 && std::abs(cubed.y - direct.y) < 0.006;
  }
  last_ = c;
  return *last_;
}

void SourceMap::map(std::int64_t i0, std::int64_t j0, int width, int height,
                    std::vector<Point>& out) {
  out.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto column = i0 / patch, row = j0 / patch;
  assert((i0 + width - 1) / patch == column && (j0 + height - 1) / patch == row);
  const Corners* const c = mapping_ ? &corners(column, row) : nullptr;
  auto* to = out.data();
  for (int l = 0; l < height; ++l) {
    const double j = static_cast<double>(j0 + l) + 0.5;
    std::array<Point, 4> columns{};
    if (c && c->smooth) columns = c->columns_at(j - static_cast<double>(row * patch));
    for (int k = 0; k < width; ++k) {
      const double i = static_cast<double>(i0 + k) + 0.5;
      if (!c) {
        *to++ = exact(i, j);
      } else if (c->smooth) {
        *to++ = Corners::at(columns, i - static_cast<double>(column * patch));
      } else {
        *to++ = rounded(exact(i, j));
      }
    }
  }
}

}  // namespace hoodoo::dem
