#include "tests/bench/narrow_band.hpp"

#include <memory>

#include "tests/bench/engine.hpp"
#include "tests/bench/table.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/surface/mesh.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::bench {
NarrowBand::NarrowBand(const Scene& scene) {
  scene_.bake.tile_cells = tile_cells;
  scene_.ground = ground_of(list_of(scene.balls, {}));
  const auto table = std::make_shared<Table>(scene);
  scene_.extent = table->extent();
  scene_.pyramids.push_back(table);
  for (int y = scene.low; y < scene.low + scene.wide; y += tile_cells) {
    for (int x = scene.low; x < scene.low + scene.wide; x += tile_cells) {
      tiles_.push_back({0, x / tile_cells, y / tile_cells});
    }
  }
}

std::size_t NarrowBand::crossings() const {
  const plan::Lattice lattice{1, dem::step_of(1), tile_cells};
  std::size_t n = 0;
  for (const auto& tile : tiles_) {
    const auto slice = slice::cut(scene_, lattice, tile);
    slice::Land land(slice, scene_.pyramids);
    volume::sample(land).for_each_crossing([&](int, const volume::Index&) { ++n; });
  }
  return n;
}

std::size_t NarrowBand::triangles() const {
  const plan::Lattice lattice{1, dem::step_of(1), tile_cells};
  std::size_t n = 0;
  volume::Volume volume;
  surface::Workspace workspace;
  for (const auto& tile : tiles_) {
    const auto slice = slice::cut(scene_, lattice, tile);
    slice::Land land(slice, scene_.pyramids);
    volume::sample(land, volume);
    n += surface::extract(volume, land, workspace).triangles.size();
  }
  return n;
}

}  // namespace hoodoo::bench
