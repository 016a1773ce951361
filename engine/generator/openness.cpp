#include "engine/generator/openness.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/hydrology/accessibility.hpp"

namespace hoodoo::generator {
namespace {

/// Samples whose accessibility is found from one window of elevations lie in a square of this side.
constexpr double square_cells = 256;

}  // namespace

std::vector<double> openness(const Site& site, std::span<const SurfaceSample> samples,
                             double most) {
  const double pixel = site.pixel(), side = square_cells * pixel;
  const auto square = [&](std::size_t i) {
    return std::pair(std::floor(samples[i].at.x / side), std::floor(samples[i].at.y / side));
  };
  std::vector<std::size_t> order(samples.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, square);
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || square(order[i]) != square(order[i - 1])) runs.emplace_back(i, i);
    runs.back().second = i + 1;
  }
  std::vector<double> open(samples.size());
  site.in_parallel(runs.size(), [&](std::size_t r) {
    const auto [x, y] = square(order[runs[r].first]);
    const Box area{{x * side, y * side, 0}, {(x + 1) * side, (y + 1) * side, 0}};
    const auto ground = site.elevations(area.grown(2 * most), pixel);
    for (auto i = runs[r].first; i < runs[r].second; ++i) {
      const auto& p = samples[order[i]].at;
      const auto cell = ground.cell(p.x, p.y);
      if (!cell) continue;
      const auto wide = static_cast<std::size_t>(ground.grid.width);
      const double ball =
          hydrology::tangent_ball(ground.grid, static_cast<std::int32_t>(*cell % wide),
                                  static_cast<std::int32_t>(*cell / wide), most);
      open[order[i]] = std::isnan(ball) ? 0 : ball / most;
    }
  });
  return open;
}

}  // namespace hoodoo::generator
