#pragma once
#include "engine/dem/raster.hpp"
#include "engine/hydrology/grid.hpp"

namespace hoodoo::hydrology {

/// Ground sizes of the cells of a raster's rows; the grid's size is set.
void set_row_sizes(Grid& grid, const dem::RasterInfo& info);

}  // namespace hoodoo::hydrology
