#include "tiling/lod/collapse.hpp"

#include <meshoptimizer.h>

#include <map>
#include <utility>

namespace hoodoo::lod {

Collapse::Collapse(const surface::Surface& surface) : surface_(surface) {
  constexpr std::uint32_t none = ~0U;
  std::vector<std::uint32_t> first(surface.points.size(), none);
  std::map<std::pair<std::uint32_t, std::uint16_t>, std::uint32_t> more;
  indices_.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto material = surface.materials[t];
    for (const auto point : surface.triangles[t]) {
      const auto fresh = static_cast<std::uint32_t>(points_.size());
      std::uint32_t vertex = first[point];
      if (vertex == none) {
        vertex = first[point] = fresh;
      } else if (materials_[vertex] != material) {
        vertex = more.try_emplace({point, material}, fresh).first->second;
      }
      if (vertex == fresh) {
        points_.push_back(point);
        materials_.push_back(material);
        for (const auto steps : surface.points[point]) {
          positions_.push_back(static_cast<float>(steps));
        }
      }
      indices_.push_back(vertex);
    }
  }
  scale_ = meshopt_simplifyScale(positions_.data(), points_.size(), 3 * sizeof(float));
}

Faces Collapse::run(double target, const std::vector<bool>& frozen) const {
  Faces faces;
  std::vector<std::uint32_t> free;
  free.reserve(indices_.size());
  for (std::size_t t = 0; t < frozen.size(); ++t) {
    if (frozen[t]) {
      faces.triangles.push_back(surface_.triangles[t]);
      faces.materials.push_back(surface_.materials[t]);
    } else {
      for (std::size_t c = 0; c < 3; ++c) free.push_back(indices_[3 * t + c]);
    }
  }
  std::vector<std::uint32_t> left(free.size());
  left.resize(meshopt_simplify(
      left.data(), free.data(), free.size(), positions_.data(), points_.size(), 3 * sizeof(float),
      0, static_cast<float>(target) / scale_, meshopt_SimplifyLockBorder, nullptr));
  for (std::size_t i = 0; i < left.size(); i += 3) {
    faces.triangles.push_back({points_[left[i]], points_[left[i + 1]], points_[left[i + 2]]});
    faces.materials.push_back(materials_[left[i]]);
  }
  return faces;
}

}  // namespace hoodoo::lod
