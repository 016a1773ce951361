#include "tiling/export/shells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "engine/base/box.hpp"
#include "tiling/lod/half_edges.hpp"

namespace hoodoo::exporting {
namespace {

constexpr auto none = std::numeric_limits<std::uint32_t>::max();

struct Part {
  bool open = false;
  double volume = 0;  // negative around air; means nothing of an open one
  Box box;

  bool is_cavity() const { return !open && volume < 0; }
};

/// Which part each vertex belongs to, by the lowest vertex that triangles connect it with.
std::vector<std::uint32_t> roots_of(const tileset::Patch& surface) {
  std::vector<std::uint32_t> above(surface.points.size());
  std::iota(above.begin(), above.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (above[v] != v) v = above[v] = above[above[v]];
    return v;
  };
  for (const auto& [a, b, c] : surface.triangles) {
    for (const auto other : {b, c}) {
      const auto p = root(a), q = root(other);
      above[std::max(p, q)] = std::min(p, q);
    }
  }
  for (std::uint32_t v = 0; v < above.size(); ++v) above[v] = root(v);
  return above;
}

std::vector<Part> parts_of(const tileset::Patch& surface, const std::vector<std::uint32_t>& roots) {
  std::vector<Part> parts(surface.points.size());
  for (const auto& [a, b, c] : surface.triangles) {
    auto& part = parts[roots[a]];
    const Vec3& from = surface.points[roots[a]];
    const Vec3 p = surface.points[a] - from, q = surface.points[b] - from,
               r = surface.points[c] - from;
    part.volume += dot(p, cross(q, r)) / 6;
    for (const auto v : {a, b, c}) part.box.add(surface.points[v]);
  }
  const lod::HalfEdges edges(surface.triangles, surface.points.size());
  for (const auto& edge : lod::topology(surface.triangles, edges).open) {
    parts[roots[edge.from]].open = true;
  }
  return parts;
}

/// Copies the triangles of parts that `wanted` takes.
template <class Wanted>
tileset::Patch copy(const tileset::Patch& surface, bool turned, const Wanted& wanted) {
  tileset::Patch patch;
  std::vector<std::uint32_t> names(surface.points.size(), none);
  const auto name = [&](std::uint32_t v) {
    if (names[v] == none) {
      names[v] = static_cast<std::uint32_t>(patch.points.size());
      patch.points.push_back(surface.points[v]);
    }
    return names[v];
  };
  for (const auto& [a, b, c] : surface.triangles) {
    if (!wanted(a)) continue;
    const auto p = name(a), q = name(b), r = name(c);
    patch.triangles.push_back(turned ? lod::Triangle{p, r, q} : lod::Triangle{p, q, r});
  }
  return patch;
}

}  // namespace

Shells sort_shells(const tileset::Patch& surface) {
  const auto roots = roots_of(surface);
  const auto parts = parts_of(surface, roots);
  std::vector<const Part*> cavities;
  for (const auto& part : parts) {
    if (part.is_cavity()) cavities.push_back(&part);
  }
  std::vector<bool> inside(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& part = parts[i];
    inside[i] = !part.open && part.volume > 0 && std::ranges::any_of(cavities, [&](const Part* c) {
      return c->box.contains(part.box) && -c->volume > part.volume;
    });
  }
  const auto is_cavity = [&](std::uint32_t v) { return parts[roots[v]].is_cavity(); };
  return {copy(surface, false, [&](std::uint32_t v) { return !is_cavity(v); }),
          copy(surface, true, is_cavity),
          copy(surface, false, [&](std::uint32_t v) { return inside[roots[v]]; })};
}

}  // namespace hoodoo::exporting
