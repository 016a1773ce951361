#include "tests/bench/hydrology.hpp"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <queue>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/hydrology/hydrology.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {
namespace {

constexpr std::int32_t cells_across = 4000;

hydrology::Grid fractal_dem() {
  hydrology::Grid grid;
  grid.width = grid.height = cells_across;
  grid.dx.assign(cells_across, 10);
  grid.dy = grid.dx;
  grid.z.reserve(std::size_t{cells_across} * cells_across);
  for (std::int32_t j = 0; j < cells_across; ++j) {
    for (std::int32_t i = 0; i < cells_across; ++i) {
      grid.z.push_back(400 * fractal(static_cast<float>(i), static_cast<float>(j)));
    }
  }
  return grid;
}

/// The resident size, now or at its peak since `forget_peak` [bytes].
double resident(std::string_view which) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != which) continue;
    double kibibytes = 0;
    status >> kibibytes;
    return 1024 * kibibytes;
  }
  return 0;
}
void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// Bytes a cell that filling, directions and areas take at their peak, with the elevations.
double peak_bytes(const hydrology::Grid& dem) {
  malloc_trim(0);
  const double before = resident("VmRSS:");
  forget_peak();
  auto grid = dem;
  hydrology::fill(grid);
  const auto to = hydrology::receivers(grid, hydrology::Routing::freeman);
  const auto drainage = hydrology::accumulate(grid, to);
  return (resident("VmHWM:") - before) / static_cast<double>(drainage.area.size());
}

/// Every cell through the heap, a trifle higher than the one it was reached from (Barnes et al.
/// 2014, Priority-Flood + epsilon); all cells sorted by elevation; shares by std::pow.
class Straightforward {
 public:
  explicit Straightforward(const hydrology::Grid& grid) : grid_(grid), neighbours_(grid) {}

  double run() {
    flood();
    return accumulate();
  }

 private:
  void flood() {
    z_ = grid_.z;
    std::vector<bool> done(z_.size());
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap;
    for (std::size_t c = 0; c < z_.size(); ++c) {
      if (neighbours_.inside(c) == 0xff) continue;
      heap.emplace(z_[c], static_cast<std::uint32_t>(c));
      done[c] = true;
    }
    while (!heap.empty()) {
      const std::size_t c = heap.top().second;
      heap.pop();
      const unsigned inside = neighbours_.inside(c);
      for (unsigned k = 0; k < 8; ++k) {
        if ((inside >> k & 1) == 0) continue;
        const auto n = neighbours_.at(c, k);
        if (done[n]) continue;
        done[n] = true;
        z_[n] = std::max(z_[n], std::nextafter(z_[c], std::numeric_limits<float>::infinity()));
        heap.emplace(z_[n], static_cast<std::uint32_t>(n));
      }
    }
  }

  double accumulate() {
    std::vector<std::uint32_t> order(z_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return z_[a] > z_[b]; });
    std::vector<double> area(z_.size(), 100);
    double outflow = 0;
    for (const std::size_t c : order) {
      std::array<double, 8> weight{};
      double sum = 0;
      const unsigned inside = neighbours_.inside(c);
      for (unsigned k = 0; k < 8; ++k) {
        if ((inside >> k & 1) == 0 || !(z_[neighbours_.at(c, k)] < z_[c])) continue;
        const double far = k % 2 == 0 ? 10 : 10 * std::sqrt(2.0);
        const double drop =
            static_cast<double>(z_[c]) - static_cast<double>(z_[neighbours_.at(c, k)]);
        weight[k] = std::pow(drop / far, 1.1);
        sum += weight[k];
      }
      if (sum == 0) outflow += area[c];
      for (unsigned k = 0; k < 8; ++k) {
        if (weight[k] > 0) area[neighbours_.at(c, k)] += area[c] * weight[k] / sum;
      }
    }
    return outflow;
  }

  const hydrology::Grid& grid_;
  hydrology::Neighbours neighbours_;
  std::vector<float> z_;
};

}  // namespace

void compare_hydrology() {
  const auto dem = fractal_dem();
  double ours = 0, theirs = 0, filling = 0, routing = 0;
  const auto [seconds, straightforward] = median_seconds(
      [&] {
        auto grid = dem;
        const double from = processor_seconds();
        hydrology::fill(grid);
        const double filled = processor_seconds();
        const auto to = hydrology::receivers(grid, hydrology::Routing::freeman);
        filling = filled - from;
        routing = processor_seconds() - filled;
        ours = hydrology::accumulate(grid, to).outflow;
      },
      [&] { theirs = Straightforward(dem).run(); });
  const double cells = static_cast<double>(dem.size());
  fmt::print("a fractal DEM of {0}^2 cells; of the area, {1:.12f} and {2:.12f} leave\n",
             cells_across, ours / (100 * cells), theirs / (100 * cells));
  fmt::print("  {:56} {:9.2f} s\n", "one heap, one sort", straightforward);
  fmt::print("  {:56} {:9.2f} s, {:.2f} to fill, {:.2f} for directions\n", "ours", seconds, filling,
             routing);
  ratio("hydrology: straightforward / ours", straightforward / seconds, ">= 2");
  ratio("hydrology: million cells a second", cells / seconds / 1e6, ">= 6");
  ratio("hydrology: bytes a cell at the peak", peak_bytes(dem), "<= 20");
}

}  // namespace hoodoo::bench
