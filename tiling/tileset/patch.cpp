#include "tiling/tileset/patch.hpp"

namespace hoodoo::tileset {

void add(Patch& patch, const glb::Decoded& tile, const Vec3& corner) {
  const auto first = static_cast<std::uint32_t>(patch.points.size());
  for (const auto& p : tile.surface.points) {
    const auto at = [&](std::size_t a) {
      return static_cast<double>(tile.origin[a] + p[a]) * tile.step;
    };
    patch.points.push_back(Vec3{at(0), at(1), at(2)} - corner);
  }
  for (const auto& [a, b, c] : tile.surface.triangles) {
    patch.triangles.push_back({first + a, first + b, first + c});
  }
}

}  // namespace hoodoo::tileset
