#include <algorithm>
#include <limits>

#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {
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
