#include "tiling/surface/curtain.hpp"

namespace hoodoo::surface {

Skirts skirts(const Surface& surface, const Mesh& mesh, slice::Land& land,
              const slice::StepPoint& origin, double depth) {
  const auto& slice = land.slice();
  Curtain curtain;
  curtain.origin = origin;
  curtain.size = slice.lattice.tile_cells * slice.lattice.units();
  curtain.depth = depth / slice.step();
  curtain.stride = 0.5 * slice.spacing() / slice.step();
  curtain.values = [&](std::span<const slice::StepPoint> points) { return land.values(points); };
  return hang(surface, mesh, curtain);
}

}  // namespace hoodoo::surface
