#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "engine/hydrology/grid.hpp"

/// engine/hydrology: elevations -> filled elevations, drainage, slope, sinks.
///
/// Water leaves a raster over its edge and into cells without an elevation. All results depend on
/// the elevations alone, not on the order in which cells are visited.
namespace hoodoo::hydrology {

/// Raises every cell to the lowest level at which its water can leave, and no cell further: no pit
/// is left, flats stay flat.
/// Source: basins and the lowest passes between them as a graph: Barnes 2016, Parallel
/// Priority-Flood depression filling for trillion cell digital elevation models on desktops or
/// clusters; here without a flood (basins.hpp).
void fill(Grid& grid);

enum class Routing { freeman, d8 };

/// To which neighbours each cell's water goes, one bit each: all that lie lower, or with `d8` the
/// one of steepest descent, the first of several. On a flat: those one step nearer to its outlet,
/// as if it fell by an infinitely small amount with every step from there. 0 where water leaves the
/// raster, in a pit, and where there is no elevation.
std::vector<std::uint8_t> receivers(const Grid& grid, Routing routing);

/// Where water gathers.
struct Drainage {
  std::vector<float> area;  // [m^2] that drains through each cell, with its own; NaN: no elevation
  double outflow = 0;       // [m^2] that arrives where water goes no further
};

/// Sums areas along `receivers`, which have no cycle. Several share by slope^exponent; on flats the
/// slope is one over the distance. `exponent` [1] in (0, 10].
/// Source: Freeman 1991, Calculating catchment area with divergent flow based on a regular grid
/// (exponent 1.1).
Drainage accumulate(const Grid& grid, std::span<const std::uint8_t> receivers,
                    double exponent = 1.1);

/// Rise over run [1] by the eight neighbours; one that is missing counts as level. NaN where there
/// is no elevation. Source: Horn 1981, Hill shading and the reflectance map.
std::vector<float> slope(const Grid& grid);

/// A^(1/2) s [m]: what a stream can do to its bed. Source: Paris et al. 2019, section 6.
std::vector<float> stream_power(const Drainage& drainage, std::span<const float> slope);

/// Ground with nothing lower beside it, away from the raster's edge and from holes.
struct Sink {
  std::int32_t i, j;  // its first cell in the order of rows
  float elevation;    // [m]
  double depth;       // [m] of the depression it lies in, from here to where that spills
  double area;        // [m^2] of that depression
  friend bool operator==(const Sink&, const Sink&) = default;
};
/// All sinks in the order of rows. A level bottom is one. `filled` is `grid` after `fill`.
/// Source: Paris et al. 2019, section 6 (cells of which all neighbours lie higher).
std::vector<Sink> sinks(const Grid& grid, const Grid& filled);

/// What a raster may take in memory.
struct FileLimits {
  std::size_t memory = std::size_t{1} << 30;  // [bytes] with all that analysing it takes
};
/// Bytes for every cell that filling, directions and areas take at their peak, one after the other,
/// with the elevations.
inline constexpr std::size_t bytes_per_cell = 20;

/// Reads a DEM, in metres. Cells of longitude and latitude have their size on the ellipsoid.
/// Errors: as dem::Raster::open; limit, when it needs more than `limits`.
Grid read(const std::filesystem::path& dem, const FileLimits& limits = {});

/// Writes a deflated GeoTIFF of tiles of 256^2 floats in the place of `dem`, whose size it has.
/// Errors: io naming the file.
void write(const std::filesystem::path& file, const std::filesystem::path& dem, const Grid& grid,
           std::span<const float> values);

}  // namespace hoodoo::hydrology
