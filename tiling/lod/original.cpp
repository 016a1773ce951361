#include "tiling/lod/original.hpp"

#include <algorithm>
#include <functional>

namespace hoodoo::lod {
namespace {

std::vector<Vec3> as_vectors(const surface::Surface& surface) {
  std::vector<Vec3> points;
  points.reserve(surface.points.size());
  for (const auto& [x, y, z] : surface.points) {
    points.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
  }
  return points;
}

/// Mean length of the triangles' first edges.
double typical_edge(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) sum += length(points[t[1]] - points[t[0]]);
  return std::max(1.0, sum / static_cast<double>(std::max<std::size_t>(1, triangles.size())));
}

}  // namespace

std::vector<Triangle> material_borders(const HalfEdges& edges,
                                       std::span<const std::uint16_t> materials) {
  std::vector<Triangle> borders;
  if (std::ranges::adjacent_find(materials, std::ranges::not_equal_to()) == materials.end()) {
    return borders;
  }
  for (std::uint32_t v = 0; v < edges.vertices(); ++v) {
    for (const auto& edge : edges.from(v)) {
      if (edge.to < v) continue;
      const auto* partner = edges.find(edge.to, v);
      if (partner != nullptr && materials[partner->triangle] != materials[edge.triangle]) {
        borders.push_back({v, edge.to, edge.to});
      }
    }
  }
  return borders;
}

Original::Original(const surface::Surface& s)
    : surface(s),
      points(as_vectors(s)),
      spacing(typical_edge(points, s.triangles)),
      edges(s.triangles, s.points.size()),
      topology(lod::topology(s.triangles, edges)),
      chords(lod::chords(edges, s.planes)),
      borders(material_borders(edges, s.materials)),
      buckets(points, s.triangles, bucket_edges * spacing) {}

bool Original::upright(const Triangle& triangle, double error, std::uint32_t& hint) const {
  const Vec3 &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
  const Vec3 middle = (a + b + c) * (1.0 / 3), normal = cross(b - a, c - a);
  return dot(normal, normal) > 0 && buckets.faces(middle, error, normal, hint);
}

}  // namespace hoodoo::lod
