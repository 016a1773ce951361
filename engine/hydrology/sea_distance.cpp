#include "engine/hydrology/sea_distance.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace hoodoo::hydrology {
namespace {

constexpr std::size_t block_rows = 32;
constexpr double infinity = std::numeric_limits<double>::infinity();

double squared(double v) { return v * v; }

/// One column: of all rows, the nearest cell by its steps along that row. Whole blocks of rows are
/// left out by their least steps; rounding keeps the order of what is compared, so this never
/// leaves out the nearest one.
class Column {
 public:
  Column(std::span<const double> dx, std::span<const double> dy)
      : dx_(dx), y_(dx.size()), steps_(dx.size()) {
    for (std::size_t j = 1; j < y_.size(); ++j) y_[j] = y_[j - 1] + 0.5 * (dy[j - 1] + dy[j]);
    for (std::size_t j = 0; j < dx.size(); j += block_rows) {
      const auto rows = dx.subspan(j, std::min(block_rows, dx.size() - j));
      narrowest_.push_back(*std::ranges::min_element(rows));
    }
    fewest_.resize(narrowest_.size());
  }

  void run(std::int32_t* first, std::size_t stride) {
    std::ranges::fill(fewest_, no_sea);
    for (std::size_t j = 0; j < steps_.size(); ++j) {
      steps_[j] = first[j * stride] & ~missing;
      auto& fewest = fewest_[j / block_rows];
      fewest = std::min(fewest, steps_[j]);
    }
    last_ = 0;
    for (std::size_t j = 0; j < steps_.size(); ++j) {
      const bool is_missing = (first[j * stride] & missing) != 0;
      const float distance = is_missing ? std::numeric_limits<float>::quiet_NaN()
                                        : static_cast<float>(std::sqrt(squared_distance(j)));
      first[j * stride] = std::bit_cast<std::int32_t>(distance);
    }
  }

 private:
  double to_row(std::size_t j, std::size_t other) const {
    if (steps_[other] == no_sea) return infinity;
    return squared(steps_[other] * (0.5 * (dx_[j] + dx_[other]))) + squared(y_[j] - y_[other]);
  }

  double squared_distance(std::size_t j) {
    // The row that was nearest to the last cell is seldom far from the nearest one now.
    double best = to_row(j, last_);
    const std::size_t own = j / block_rows;
    search(j, own, best);
    for (std::size_t b = own; b-- > 0;) {
      if (squared(y_[j] - y_[b * block_rows + block_rows - 1]) >= best) break;
      search(j, b, best);
    }
    for (std::size_t b = own + 1; b < fewest_.size(); ++b) {
      if (squared(y_[j] - y_[b * block_rows]) >= best) break;
      search(j, b, best);
    }
    return best;
  }

  void search(std::size_t j, std::size_t block, double& best) {
    if (fewest_[block] == no_sea) return;
    const std::size_t low = block * block_rows, high = std::min(low + block_rows, steps_.size());
    const double away = j < low ? y_[low] - y_[j] : j >= high ? y_[j] - y_[high - 1] : 0;
    const double aside = fewest_[block] * (0.5 * (dx_[j] + narrowest_[block]));
    if (squared(aside) + squared(away) >= best) return;
    for (std::size_t other = low; other < high; ++other) {
      const double found = to_row(j, other);
      if (found < best) best = found, last_ = other;
    }
  }

  std::span<const double> dx_;
  std::vector<double> y_;  // of the middles of rows
  std::vector<std::int32_t> steps_, fewest_;
  std::vector<double> narrowest_;
  std::size_t last_ = 0;
};

}  // namespace

void steps_in_row(std::span<const float> z, double sea_level, std::span<std::int32_t> steps) {
  std::int32_t away = no_sea;
  const auto next = [&](std::size_t i) {
    const bool sea = static_cast<double>(z[i]) <= sea_level;
    away = sea ? 0 : std::min(away + 1, no_sea);
  };
  for (std::size_t i = 0; i < z.size(); ++i) next(i), steps[i] = away;
  away = no_sea;
  for (std::size_t i = z.size(); i-- > 0;) {
    next(i);
    steps[i] = std::min(steps[i], away) | (std::isnan(z[i]) ? missing : 0);
  }
}

void steps_to_distances(std::span<std::int32_t> steps, std::size_t width,
                        std::span<const double> dx, std::span<const double> dy) {
  Column column(dx, dy);
  for (std::size_t i = 0; i < width; ++i) column.run(steps.data() + i, width);
}

std::vector<float> sea_distance(const Grid& grid, double sea_level) {
  std::vector<std::int32_t> steps(grid.size());
  const auto width = static_cast<std::size_t>(grid.width);
  for (std::size_t first = 0; first < grid.size(); first += width) {
    steps_in_row(std::span(grid.z).subspan(first, width), sea_level,
                 std::span(steps).subspan(first, width));
  }
  steps_to_distances(steps, width, grid.dx, grid.dy);
  std::vector<float> distances(grid.size());
  std::ranges::transform(steps, distances.begin(),
                         [](std::int32_t bits) { return std::bit_cast<float>(bits); });
  return distances;
}

}  // namespace hoodoo::hydrology
