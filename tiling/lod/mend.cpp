#include <utility>

#include "tiling/lod/faces.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {
namespace {

constexpr std::uint8_t shared_planes = static_cast<std::uint8_t>(~surface::world_edge);

/// Triangles with a vertex on a border plane.
std::vector<std::uint32_t> at_borders(const Faces& faces, const std::vector<std::uint8_t>& planes) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t t = 0; t < faces.triangles.size(); ++t) {
    const auto& [a, b, c] = faces.triangles[t];
    if (((planes[a] | planes[b] | planes[c]) & shared_planes) != 0) found.push_back(t);
  }
  return found;
}

/// One pass over the chords there are; false when it turned none.
bool turn_some(Faces& faces, const std::vector<std::uint8_t>& planes,
               const std::vector<std::uint32_t>& candidates) {
  std::vector<Triangle> triangles;
  triangles.reserve(candidates.size());
  for (const auto t : candidates) triangles.push_back(faces.triangles[t]);
  const HalfEdges edges(triangles, planes.size());
  std::vector<bool> touched(candidates.size());
  bool turned = false;
  const auto in_plane = [&](std::uint32_t a, std::uint32_t b, std::uint8_t bits) {
    return (planes[a] & planes[b] & bits) != 0;
  };
  const auto turn = [&](std::uint32_t a, const HalfEdges::HalfEdge& edge) {
    const std::uint32_t c = edge.to;
    const auto* partner = edges.find(c, a);
    if (partner == nullptr || touched[edge.triangle] || touched[partner->triangle]) return;
    const std::uint32_t x = edge.apex, y = partner->apex;
    if (x == y || in_plane(x, y, shared_planes) || edges.find(x, y) || edges.find(y, x)) return;
    touched[edge.triangle] = touched[partner->triangle] = true;
    const auto first = candidates[edge.triangle], second = candidates[partner->triangle];
    // The half that lies in the plane brings the border edges, which keep their material.
    const auto chord = static_cast<std::uint8_t>(planes[a] & planes[c] & shared_planes);
    const auto material = faces.materials[in_plane(y, y, chord) ? second : first];
    const Turn turned_edge{a, c, x, y};
    faces.triangles[first] = turned_edge.first();
    faces.triangles[second] = turned_edge.second();
    faces.materials[first] = faces.materials[second] = material;
    turned = true;
  };
  for (std::uint32_t a = 0; a < planes.size(); ++a) {
    if ((planes[a] & shared_planes) == 0) continue;
    for (const auto& edge : edges.from(a)) {
      if (a < edge.to && in_plane(a, edge.to, shared_planes)) turn(a, edge);
    }
  }
  return turned;
}

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> chords(
    const HalfEdges& edges, const std::vector<std::uint8_t>& planes) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  for (std::uint32_t a = 0; a < planes.size(); ++a) {
    if ((planes[a] & shared_planes) == 0) continue;
    for (const auto& edge : edges.from(a)) {
      if (a < edge.to && (planes[a] & planes[edge.to] & shared_planes) != 0 &&
          edges.find(edge.to, a) != nullptr) {
        found.emplace_back(a, edge.to);
      }
    }
  }
  return found;
}

void drop_fins(Faces& faces, std::size_t vertices) {
  const HalfEdges edges(faces.triangles, vertices);
  std::vector<bool> dropped(faces.triangles.size());
  bool any = false;
  for (std::uint32_t t = 0; t < faces.triangles.size(); ++t) {
    const auto& [a, b, c] = faces.triangles[t];
    if (dropped[t]) continue;
    for (const auto& edge : edges.from(b)) {
      if (edge.to != a || edge.apex != c || dropped[edge.triangle]) continue;
      any = dropped[t] = dropped[edge.triangle] = true;
      break;
    }
  }
  if (!any) return;
  Faces kept;
  for (std::size_t t = 0; t < dropped.size(); ++t) {
    if (dropped[t]) continue;
    kept.triangles.push_back(faces.triangles[t]);
    kept.materials.push_back(faces.materials[t]);
  }
  faces = std::move(kept);
}

void turn_chords(Faces& faces, const std::vector<std::uint8_t>& planes) {
  const auto candidates = at_borders(faces, planes);
  // Chords over several border vertices come off one vertex at a time.
  for (int pass = 0; pass < 64 && turn_some(faces, planes, candidates); ++pass) {
  }
}

}  // namespace hoodoo::lod
