#pragma once
#include <vector>

#include "engine/base/vector.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/lod/half_edges.hpp"

namespace hoodoo::tileset {

/// Surfaces of one or more tiles, without skirts [m], relative to one corner.
struct Patch {
  std::vector<Vec3> points;
  std::vector<lod::Triangle> triangles;
};

/// Puts a tile's surface beside what is there; its points and triangles keep their order.
void add(Patch& patch, const glb::Decoded& tile, const Vec3& corner);

}  // namespace hoodoo::tileset
