#include "tests/bench/table.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::bench {

Table::Table(const Scene& scene) : scene_(scene), corner_(scene.low - scene.margin - 0.5) {
  const double low = scene.low, high = scene.low + scene.wide;
  extent_ = {{low, low, -1000}, {high, high, 1000}};
  const std::int64_t n = scene.wide + 2 * scene.margin;
  levels_.push_back({corner_, corner_, 1, 1, n, n});
}

dem::Window Table::window(int, const Box& area) const {
  const int n = scene_.wide + 2 * scene_.margin;
  const auto first = [&](double at) {
    return std::clamp(static_cast<int>(std::floor(at - corner_)) - 3, 0, n - 1);
  };
  const auto last = [&](double at) {
    return std::clamp(static_cast<int>(std::ceil(at - corner_)) + 3, 1, n);
  };
  const int i0 = first(area.min.x), j0 = first(area.min.y);
  const int i1 = std::max(last(area.max.x), i0 + 1), j1 = std::max(last(area.max.y), j0 + 1);
  std::vector<float> samples;
  samples.reserve(static_cast<std::size_t>(i1 - i0) * static_cast<std::size_t>(j1 - j0));
  for (int j = j0; j < j1; ++j) {
    const auto row = scene_.samples.begin() + static_cast<std::ptrdiff_t>(j) * n;
    samples.insert(samples.end(), row + i0, row + i1);
  }
  return {corner_, corner_, 1, 1, i0, j0, i1 - i0, j1 - j0, std::move(samples)};
}

std::optional<Interval> Table::bounds(int, const Box& area) const {
  return scene_.window.bounds(area);
}

}  // namespace hoodoo::bench
