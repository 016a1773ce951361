#pragma once
#include <map>

#include "tests/tiling/lod/shapes.hpp"
#include "tiling/surface/mesh.hpp"

namespace hoodoo::shapes {

/// A surface with normals and colours that depend on the position alone, vertices split by
/// material. `origin` is added to the points before they are looked at.
inline surface::Mesh mesh_of(const surface::Surface& surface,
                             const std::array<std::int64_t, 3>& origin = {}) {
  surface::Mesh mesh;
  std::map<std::pair<std::uint32_t, std::uint16_t>, std::uint32_t> vertices;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto point = surface.triangles[t][c];
      const auto fresh = static_cast<std::uint32_t>(mesh.points.size());
      const auto at = vertices.try_emplace({point, surface.materials[t]}, fresh).first->second;
      triangle[c] = at;
      if (at != fresh) continue;
      const auto& p = surface.points[point];
      const auto bits = random_bits(5U, origin[0] + p[0], origin[1] + p[1], origin[2] + p[2]);
      const Vec3 n = normalized({unit_real(bits) - 0.5, unit_real(mix(bits)) - 0.5, 1});
      mesh.points.push_back(p);
      mesh.normals.push_back(
          {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
      mesh.colors.push_back({static_cast<std::uint8_t>(p[2] & 255), 100, 50, 255});
      mesh.materials.push_back(surface.materials[t]);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

/// A wall below the south border of a tile.
inline surface::Mesh skirt_of(const surface::Mesh& mesh) {
  surface::Mesh skirt;
  std::vector<std::array<std::int32_t, 3>> row;
  for (const auto& p : mesh.points) {
    if (p[1] == 0) row.push_back(p);
  }
  std::ranges::sort(row);
  row.erase(std::unique(row.begin(), row.end()), row.end());
  for (const auto& p : row) {
    for (const int down : {0, 512}) {
      skirt.points.push_back({p[0], p[1], p[2] - down});
      skirt.normals.push_back({0, -1, 0});
      skirt.colors.push_back({90, 80, 70, 255});
      skirt.materials.push_back(0);
    }
  }
  for (std::uint32_t i = 0; i + 3 < skirt.points.size(); i += 2) {
    skirt.triangles.push_back({i, i + 1, i + 2});
    skirt.triangles.push_back({i + 2, i + 1, i + 3});
  }
  return skirt;
}

}  // namespace hoodoo::shapes
