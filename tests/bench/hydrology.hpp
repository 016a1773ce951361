#pragma once

namespace hoodoo::bench {

/// Filling, Freeman's directions and accumulation of a fractal DEM of 4000^2 cells against the
/// straightforward way: one binary heap, one sort.
void compare_hydrology();

}  // namespace hoodoo::bench
