#include <algorithm>
#include <tuple>

#include "engine/base/vector.hpp"
#include "tiling/lod/half_edges.hpp"
#include "tiling/lod/lod.hpp"

namespace hoodoo::lod {
namespace {

using Point = std::array<std::int32_t, 3>;

Vec3 as_vector(const Point& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

bool has_area(const surface::Surface& surface, const Triangle& t) {
  const Vec3 a = as_vector(surface.points[t[0]]);
  const Vec3 normal =
      cross(as_vector(surface.points[t[1]]) - a, as_vector(surface.points[t[2]]) - a);
  return dot(normal, normal) > 0;
}

bool positions_are_unique(const surface::Surface& surface) {
  auto points = surface.points;
  std::ranges::sort(points);
  return std::ranges::adjacent_find(points) == points.end();
}

Topology topology_of(const surface::Surface& surface) {
  return topology(surface.triangles, HalfEdges(surface.triangles, surface.points.size()));
}

/// Open edges with the material beside them, and vertices of several fans, by position.
struct Outline {
  std::vector<std::tuple<Point, Point, std::uint16_t>> open;
  std::vector<std::pair<Point, std::uint32_t>> split;
  std::int64_t euler;
  friend bool operator==(const Outline&, const Outline&) = default;
};

Outline outline(const surface::Surface& surface, const Topology& topology) {
  Outline result;
  for (const auto& edge : topology.open) {
    result.open.emplace_back(surface.points[edge.from], surface.points[edge.to],
                             surface.materials[edge.triangle]);
  }
  for (const auto& fans : topology.split) {
    result.split.emplace_back(surface.points[fans.vertex], fans.count);
  }
  std::ranges::sort(result.open);
  std::ranges::sort(result.split);
  result.euler = topology.euler;
  return result;
}

/// Open only where the surface is marked as ending.
bool ends_at_borders(const surface::Surface& surface, const Topology& topology) {
  const auto on_border = [&](const Topology::Open& edge) {
    return (surface.planes[edge.from] & surface.planes[edge.to]) != 0;
  };
  const auto at_world_edge = [&](const Topology::Fans& fans) {
    return (surface.planes[fans.vertex] & surface::world_edge) != 0;
  };
  return std::ranges::all_of(topology.open, on_border) &&
         std::ranges::all_of(topology.split, at_world_edge);
}

}  // namespace

std::uint64_t world_edges(const surface::Surface& surface) {
  const Topology topology = topology_of(surface);
  return static_cast<std::uint64_t>(std::ranges::count_if(topology.open, [&](const auto& edge) {
    return (surface.planes[edge.from] & surface.planes[edge.to] & surface::world_edge) != 0;
  }));
}

bool is_manifold(const surface::Surface& surface, const surface::Surface* original) {
  const auto area = [&](const Triangle& t) { return has_area(surface, t); };
  if (!std::ranges::all_of(surface.triangles, area) || !positions_are_unique(surface)) return false;
  const Topology here = topology_of(surface);
  if (!here.sound()) return false;
  if (original == nullptr) return ends_at_borders(surface, here);
  return outline(surface, here) == outline(*original, topology_of(*original));
}

}  // namespace hoodoo::lod
