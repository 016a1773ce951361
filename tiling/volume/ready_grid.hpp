#pragma once
#include <array>
#include <span>

#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {

/// Values at lattice points that are in memory already, x fastest; solid where above `iso`.
struct ReadyGrid {
  std::span<const float> values;
  std::array<int, 3> size;  // points along each axis, at least 2
  float iso = 0.5F;

  float at(int x, int y, int z) const {
    return values[(static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) +
                   static_cast<std::size_t>(y)) *
                      static_cast<std::size_t>(size[0]) +
                  static_cast<std::size_t>(x)];
  }
};

/// The Hermite data of a grid from (0, 0, 0) on: crossings by linear interpolation along each edge,
/// normals by central differences (one-sided at the grid's border) interpolated between its ends.
/// Material 0 throughout.
/// Source: Lorensen, Cline 1987, Marching Cubes, for both.
Volume volume_of(const ReadyGrid& grid);
/// The same in the memory of `volume`.
void read(const ReadyGrid& grid, Volume& volume);

}  // namespace hoodoo::volume
