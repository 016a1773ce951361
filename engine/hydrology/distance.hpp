#pragma once
#include <array>
#include <cmath>

#include "engine/hydrology/grid.hpp"

namespace hoodoo::hydrology {

/// Distances [m] between the middles of a cell of row `j` and its neighbours. Rows of different
/// size meet half way, so that both ends agree; beyond the raster they go on as they are.
class Distances {
 public:
  Distances(const Grid& grid, std::int32_t j) {
    const auto a = static_cast<std::size_t>(j);
    for (std::size_t k = 0; k < 8; ++k) {
      const std::int32_t other = j + next_row[k];
      const auto b = other < 0 || other >= grid.height ? a : static_cast<std::size_t>(other);
      const double x = next_column[k] == 0 ? 0 : 0.5 * (grid.dx[a] + grid.dx[b]);
      const double y = next_row[k] == 0 ? 0 : 0.5 * (grid.dy[a] + grid.dy[b]);
      distances_[k] = std::sqrt(x * x + y * y);
    }
  }
  double operator[](std::size_t k) const { return distances_[k]; }

 private:
  std::array<double, 8> distances_{};
};

/// How far water falls from one cell to a neighbour [m]; on a flat it counts as one.
inline double fall(float from, float to) {
  return from > to ? static_cast<double>(from) - static_cast<double>(to) : 1;
}

}  // namespace hoodoo::hydrology
