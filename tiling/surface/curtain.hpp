#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tiling/surface/mesh.hpp"

namespace hoodoo::surface {

/// What skirts need to know of a tile. All lengths in steps.
struct Curtain {
  slice::StepPoint origin{};  // of the surface's (0,0,0)
  std::int32_t size = 0;      // of the tile in x and y
  double depth = 0;
  double stride = 0;  // of the march that measures the solid's thickness
  /// The field, solid above 1/2, at points counted from the scene origin.
  std::function<std::vector<float>(std::span<const slice::StepPoint>)> values;
};

/// The skirts of a surface whose mesh is `mesh`, triangle by triangle; as `skirts`, whose work
/// this is.
Skirts hang(const Surface& surface, const Mesh& mesh, const Curtain& curtain);

}  // namespace hoodoo::surface
