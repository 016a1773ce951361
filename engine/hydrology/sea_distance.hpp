#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "engine/hydrology/grid.hpp"

/// Distance to the sea: between the middles of cells, exact.
///
/// North and south it is counted by the sizes of the rows in between, east and west by the mean
/// size of a cell of both rows, which on longitude and latitude is right to the second order of the
/// distance over the Earth's radius. Cells without an elevation are neither sea nor in the way.
namespace hoodoo::hydrology {

/// [m] from each cell to the nearest one at or below `sea_level` [m]: 0 in the sea, NaN where there
/// is no elevation, infinite where there is no sea.
std::vector<float> sea_distance(const Grid& grid, double sea_level);

/// Its two halves, for rasters of which a part is held. First each row by itself: cells to the
/// nearest sea of the row, `no_sea` where it has none. Those without an elevation are told apart by
/// `missing`.
inline constexpr std::int32_t no_sea = 0x3fffffff, missing = 0x40000000;
void steps_in_row(std::span<const float> z, double sea_level, std::span<std::int32_t> steps);

/// Then columns, whole ones: replaces steps by the bits of the distance. `width` columns,
/// `dx.size()` rows.
void steps_to_distances(std::span<std::int32_t> steps, std::size_t width,
                        std::span<const double> dx, std::span<const double> dy);

}  // namespace hoodoo::hydrology
