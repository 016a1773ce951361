#include "tiling/surface/mesh.hpp"

#include <algorithm>
#include <limits>
#include <span>

#include "engine/base/math.hpp"

namespace hoodoo::surface {
namespace {

/// Colour of strata: the material's, times this much where the rock is weakest, by as much more as
/// it resists.
constexpr double darkest = 0.82, lighter = 0.36;

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// Linear light of each sRGB level, both in 8 bits. IEC 61966-2-1.
const std::array<std::uint8_t, 256>& linear_of_srgb() {
  static const auto table = [] {
    std::array<std::uint8_t, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      const double linear = v <= 0.04045 ? v / 12.92 : bit_pow((v + 0.055) / 1.055, 2.4);
      t[i] = static_cast<std::uint8_t>(255 * linear + 0.5);
    }
    return t;
  }();
  return table;
}

std::array<std::uint8_t, 4> stratum_color(const std::array<std::uint8_t, 3>& srgb,
                                          float resistance) {
  const double factor = darkest + lighter * std::clamp(static_cast<double>(resistance), 0.0, 1.0);
  std::array<std::uint8_t, 4> color{0, 0, 0, 255};
  for (std::size_t i = 0; i < 3; ++i) {
    const double level = std::min(255.0, static_cast<double>(srgb[i]) * factor + 0.5);
    color[i] = linear_of_srgb()[static_cast<std::size_t>(level)];
  }
  return color;
}

/// One vertex per point and material, in the order in which triangles ask for them.
class Splitter {
 public:
  Splitter(const Surface& surface, Mesh& mesh)
      : surface_(surface), mesh_(mesh), first_(surface.points.size(), none) {}

  std::uint32_t vertex(std::uint32_t point, std::uint16_t material) {
    std::uint32_t* link = &first_[point];
    while (*link != none) {
      if (mesh_.materials[*link] == material) return *link;
      link = &next_[*link];
    }
    const auto made = static_cast<std::uint32_t>(mesh_.points.size());
    *link = made;
    next_.push_back(none);
    mesh_.points.push_back(surface_.points[point]);
    mesh_.materials.push_back(material);
    source.push_back(point);
    return made;
  }

  std::vector<std::uint32_t> source;  // the point of each vertex

 private:
  const Surface& surface_;
  Mesh& mesh_;
  std::vector<std::uint32_t> first_, next_;  // vertices of a point, chained
};

}  // namespace

Mesh shade(const Surface& surface, slice::Land& land, const slice::StepPoint& origin) {
  Mesh mesh;
  Splitter splitter(surface, mesh);
  mesh.triangles.reserve(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const auto material = surface.materials[t];
    const auto va = splitter.vertex(a, material), vb = splitter.vertex(b, material);
    mesh.triangles.push_back({va, vb, splitter.vertex(c, material)});
  }

  std::vector<slice::StepPoint> points;
  points.reserve(surface.points.size());
  for (const auto& [x, y, z] : surface.points) {
    points.push_back({origin[0] + x, origin[1] + y, origin[2] + z});
  }
  const auto normals = land.normals(points);
  const auto resistances = land.resistances(points);
  const auto& materials = land.slice().ground.materials;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const auto point = splitter.source[v];
    mesh.normals.push_back(normals[point]);
    mesh.colors.push_back(stratum_color(materials[mesh.materials[v]].color, resistances[point]));
  }
  return mesh;
}

}  // namespace hoodoo::surface
