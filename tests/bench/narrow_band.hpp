#pragma once
#include <cstddef>
#include <vector>

#include "engine/scene/scene.hpp"
#include "tests/bench/scene.hpp"
#include "tiling/plan/plan.hpp"

namespace hoodoo::bench {

/// A scene of balls through the stages that find its surface, tile after tile: cut, opened, signs
/// of the blocks that can hold a surface, crossings with their normals and materials.
class NarrowBand {
 public:
  /// The part's corner is a multiple of a tile.
  explicit NarrowBand(const Scene& scene);
  static constexpr int tile_cells = 128;

  /// Crossed edges of all tiles.
  std::size_t crossings() const;
  /// Triangles of all tiles, surface extracted.
  std::size_t triangles() const;

 private:
  scene::Scene scene_;
  std::vector<plan::Key> tiles_;
};

}  // namespace hoodoo::bench
