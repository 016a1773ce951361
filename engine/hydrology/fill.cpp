#include "engine/hydrology/basins.hpp"
#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {

void fill(Grid& grid) {
  if (grid.size() == 0) return;
  Basins basins({grid.z, static_cast<std::size_t>(grid.width)});
  basins.raise(spill_levels(basins.passes(), basins.count()));
}

}  // namespace hoodoo::hydrology
