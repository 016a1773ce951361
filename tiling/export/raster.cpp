#include "tiling/export/raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace hoodoo::exporting {
namespace {

constexpr double none = -std::numeric_limits<double>::infinity();

}  // namespace

Raster::Raster(const Canvas& canvas, std::int64_t first, std::int64_t count)
    : canvas_(canvas),
      first_(first),
      count_(count),
      heights_(static_cast<std::size_t>(canvas.width * count), none) {}

std::span<const double> Raster::row(std::int64_t y) const {
  const auto width = static_cast<std::size_t>(canvas_.width);
  return std::span(heights_).subspan(static_cast<std::size_t>(y - first_) * width, width);
}

void Raster::paint(const glb::Decoded& tile) {
  std::vector<Corner> corners;
  corners.reserve(tile.surface.points.size());
  for (const auto& p : tile.surface.points) {
    const auto metres = [&](std::size_t a) {
      return static_cast<double>(tile.origin[a] + p[a]) * tile.step;
    };
    const auto pixels = [&](std::size_t a, std::int64_t first) {
      return metres(a) / canvas_.pixel - (static_cast<double>(first) + 0.5);
    };
    corners.push_back({pixels(0, canvas_.x), pixels(1, first_), metres(2)});
  }
  for (const auto& [a, b, c] : tile.surface.triangles) paint(corners[a], corners[b], corners[c]);
}

void Raster::paint(const Corner& a, const Corner& b, const Corner& c) {
  // Twice the area left of the edge and (x, y). Both triangles at an edge reckon from the same end,
  // so that what rounding takes from one it gives to the other.
  const auto beside = [](const Corner& from, const Corner& to, double x, double y) {
    const bool turned = std::tie(to.x, to.y) < std::tie(from.x, from.y);
    const Corner &p = turned ? to : from, &q = turned ? from : to;
    const double area = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    return turned ? -area : area;
  };
  if (beside(a, b, c.x, c.y) <= 0) return;  // it is upright or looks down
  const auto first = [](double low) {
    return static_cast<std::int64_t>(std::ceil(std::max(low, 0.0)));
  };
  const auto last = [](double high, std::int64_t count) {
    return static_cast<std::int64_t>(std::floor(std::min(high, static_cast<double>(count - 1))));
  };
  const auto [west, east] = std::minmax({a.x, b.x, c.x});
  const auto [south, north] = std::minmax({a.y, b.y, c.y});
  for (auto j = first(south); j <= last(north, count_); ++j) {
    for (auto i = first(west); i <= last(east, canvas_.width); ++i) {
      const auto x = static_cast<double>(i), y = static_cast<double>(j);
      const double at_c = beside(a, b, x, y), at_a = beside(b, c, x, y), at_b = beside(c, a, x, y);
      const double whole = at_a + at_b + at_c;
      if (at_a < 0 || at_b < 0 || at_c < 0 || !(whole > 0)) continue;
      auto& height = heights_[static_cast<std::size_t>(j * canvas_.width + i)];
      height = std::max(height, (at_a * a.z + at_b * b.z + at_c * c.z) / whole);
    }
  }
}

}  // namespace hoodoo::exporting
