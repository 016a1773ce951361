#pragma once
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {

inline constexpr float hole = std::numeric_limits<float>::quiet_NaN();

inline Grid grid_of(std::int32_t width, std::vector<float> z, double cell = 1) {
  Grid grid;
  grid.width = width;
  grid.height = static_cast<std::int32_t>(z.size()) / width;
  grid.z = std::move(z);
  grid.dx.assign(static_cast<std::size_t>(grid.height), cell);
  grid.dy = grid.dx;
  return grid;
}

/// Rough ground on few levels, with pits, flats and holes.
inline Grid rough(std::uint32_t seed, std::int32_t width, std::int32_t height, int levels,
                  double holes) {
  std::mt19937 random(seed);
  std::vector<float> z;
  for (std::int32_t n = 0; n < width * height; ++n) {
    const bool is_hole = static_cast<double>(random() % 1000) < 1000 * holes;
    z.push_back(is_hole ? hole
                        : static_cast<float>(random() % static_cast<std::uint32_t>(levels)) - 3);
  }
  return grid_of(width, std::move(z), 2);
}

}  // namespace hoodoo::hydrology
