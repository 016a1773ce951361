#include <algorithm>
#include <limits>

#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {
namespace {

/// The level ground around `first`, as marked cells; whether it is a sink.
class Bottoms {
 public:
  Bottoms(const Grid& grid, const Grid& filled)
      : grid_(grid), filled_(filled), neighbours_(grid), seen_(grid.size()) {}

  std::vector<Sink> run() {
    find_depressions();
    std::vector<Sink> sinks;
    for (std::size_t cell = 0; cell < grid_.size(); ++cell) {
      if (!grid_.valid(cell) || seen_[cell] != 0 || !is_bottom(cell)) continue;
      const auto wide = static_cast<std::size_t>(grid_.width);
      const float z = grid_.z[cell];
      const double depth = static_cast<double>(filled_.z[cell]) - static_cast<double>(z);
      sinks.push_back({static_cast<std::int32_t>(cell % wide),
                       static_cast<std::int32_t>(cell / wide), z, depth,
                       areas_[depression_[cell]]});
    }
    return sinks;
  }

 private:
  /// Numbers the connected ground under water, from 1.
  void find_depressions() {
    depression_.assign(grid_.size(), 0);
    areas_.assign(1, 0);
    std::vector<std::size_t> open;
    for (std::size_t first = 0; first < grid_.size(); ++first) {
      if (!drowned(first) || depression_[first] != 0) continue;
      const auto number = static_cast<std::uint32_t>(areas_.size());
      double area = 0;
      open.push_back(first);
      depression_[first] = number;
      while (!open.empty()) {
        const auto cell = open.back();
        open.pop_back();
        area += grid_.area(static_cast<std::int32_t>(cell / static_cast<std::size_t>(grid_.width)));
        for (unsigned k = 0; k < 8; ++k) {  // water never stands on the edge
          const auto next = neighbours_.at(cell, k);
          if (!drowned(next) || depression_[next] != 0) continue;
          depression_[next] = number;
          open.push_back(next);
        }
      }
      areas_.push_back(area);
    }
  }
  bool drowned(std::size_t cell) const {
    return grid_.valid(cell) && filled_.z[cell] > grid_.z[cell];
  }

  /// Marks the level ground around `first`. Where a neighbour of it lies lower, or it lies beside
  /// the raster's edge or a hole, it is none.
  bool is_bottom(std::size_t first) {
    bool bottom = true;
    level_.assign(1, first);
    seen_[first] = 1;
    while (!level_.empty()) {
      const auto cell = level_.back();
      level_.pop_back();
      const unsigned valid = neighbours_.valid(cell);
      bottom = bottom && valid == 0xff;
      for (unsigned k = 0; k < 8; ++k) {
        if ((valid >> k & 1) == 0) continue;
        const auto next = neighbours_.at(cell, k);
        bottom = bottom && grid_.z[next] >= grid_.z[cell];
        if (grid_.z[next] != grid_.z[cell] || seen_[next] != 0) continue;
        seen_[next] = 1;
        level_.push_back(next);
      }
    }
    return bottom;
  }

  const Grid& grid_;
  const Grid& filled_;
  Neighbours neighbours_;
  std::vector<std::uint8_t> seen_;
  std::vector<std::uint32_t> depression_;
  std::vector<double> areas_;
  std::vector<std::size_t> level_;
};

}  // namespace

std::vector<Sink> sinks(const Grid& grid, const Grid& filled) {
  return Bottoms(grid, filled).run();
}

std::vector<float> slope(const Grid& grid) {
  std::vector<float> result(grid.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::int32_t j = 0; j < grid.height; ++j) {
    const double per_x = 1 / (8 * grid.dx[static_cast<std::size_t>(j)]);
    const double per_y = 1 / (8 * grid.dy[static_cast<std::size_t>(j)]);
    for (std::int32_t i = 0; i < grid.width; ++i) {
      const auto cell = grid.index(i, j);
      if (!grid.valid(cell)) continue;
      const auto z = [&](std::int32_t di, std::int32_t dj) {
        const bool there = grid.holds(i + di, j + dj) && grid.valid(grid.index(i + di, j + dj));
        return static_cast<double>(grid.z[there ? grid.index(i + di, j + dj) : cell]);
      };
      const double x = (z(1, -1) + 2 * z(1, 0) + z(1, 1)) - (z(-1, -1) + 2 * z(-1, 0) + z(-1, 1));
      const double y = (z(-1, 1) + 2 * z(0, 1) + z(1, 1)) - (z(-1, -1) + 2 * z(0, -1) + z(1, -1));
      result[cell] =
          static_cast<float>(std::sqrt(x * per_x * (x * per_x) + y * per_y * (y * per_y)));
    }
  }
  return result;
}

std::vector<float> stream_power(const Drainage& drainage, std::span<const float> slope) {
  std::vector<float> power(slope.size());
  for (std::size_t cell = 0; cell < power.size(); ++cell) {
    power[cell] = static_cast<float>(std::sqrt(static_cast<double>(drainage.area[cell])) *
                                     static_cast<double>(slope[cell]));
  }
  return power;
}

}  // namespace hoodoo::hydrology
