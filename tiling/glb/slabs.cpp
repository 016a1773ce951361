#include "tiling/glb/slabs.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

namespace hoodoo::glb {
namespace {

/// Slab of each triangle, from 0.
std::vector<std::size_t> places(const surface::Mesh& mesh, std::size_t count) {
  const std::size_t size = mesh.triangles.size();
  std::vector<std::int64_t> height(size);  // three times the mean
  std::vector<std::uint32_t> order(size);
  for (std::uint32_t t = 0; t < size; ++t) {
    order[t] = t;
    for (const auto v : mesh.triangles[t]) height[t] += mesh.points[v][2];
  }
  std::ranges::sort(
      order, [&](auto a, auto b) { return std::tie(height[a], a) < std::tie(height[b], b); });
  std::vector<std::size_t> place(size);
  for (std::size_t i = 0; i < size; ++i) place[order[i]] = i * count / size;
  return place;
}

/// The triangles of `mesh` whose place is `slab`, with their vertices alone, in the order of both.
surface::Mesh part(const surface::Mesh& mesh, std::span<const std::size_t> place,
                   std::size_t slab) {
  constexpr std::uint32_t unused = ~0U;
  std::vector<std::uint32_t> names(mesh.points.size(), unused);
  surface::Mesh out;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (place[t] != slab) continue;
    out.triangles.push_back(mesh.triangles[t]);
    for (const auto v : mesh.triangles[t]) names[v] = 0;
  }
  for (std::size_t v = 0; v < names.size(); ++v) {
    if (names[v] == unused) continue;
    names[v] = static_cast<std::uint32_t>(out.points.size());
    out.points.push_back(mesh.points[v]);
    out.normals.push_back(mesh.normals[v]);
    out.colors.push_back(mesh.colors[v]);
    out.materials.push_back(mesh.materials[v]);
  }
  for (auto& triangle : out.triangles) {
    for (auto& v : triangle) v = names[v];
  }
  return out;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void append(Decoded::Part& to, const Decoded::Part& from,
            const std::array<std::int64_t, 3>& offset) {
  const auto first = static_cast<std::uint32_t>(to.points.size());
  for (auto p : from.points) {
    for (std::size_t a = 0; a < 3; ++a) p[a] += static_cast<std::int32_t>(offset[a]);
    to.points.push_back(p);
  }
  append(to.normals, from.normals);
  append(to.colors, from.colors);
  append(to.materials, from.materials);
  for (const auto& [a, b, c] : from.triangles) {
    to.triangles.push_back({first + a, first + b, first + c});
  }
}

}  // namespace

std::vector<Content> slabs(const Content& content, std::span<const std::uint32_t> hosts,
                           std::size_t most) {
  assert(most > 0 && hosts.size() == content.skirt.triangles.size());
  const std::size_t count = (content.surface.triangles.size() + most - 1) / most;
  if (count <= 1) return {content};
  const auto place = places(content.surface, count);
  std::vector<std::size_t> skirt_place;
  skirt_place.reserve(hosts.size());
  for (const auto host : hosts) skirt_place.push_back(place[host]);
  std::vector<Content> all;
  for (std::size_t slab = 0; slab < count; ++slab) {
    all.push_back({part(content.surface, place, slab), part(content.skirt, skirt_place, slab),
                   content.origin, content.step, content.draco_speed, content.materials});
  }
  return all;
}

Decoded join(std::vector<Decoded> slabs) {
  assert(!slabs.empty());
  Decoded all = std::move(slabs.front());
  for (std::size_t i = 1; i < slabs.size(); ++i) {
    const auto& slab = slabs[i];
    assert(slab.step == all.step);
    std::array<std::int64_t, 3> offset{};
    for (std::size_t a = 0; a < 3; ++a) offset[a] = slab.origin[a] - all.origin[a];
    append(all.surface, slab.surface, offset);
    append(all.skirt, slab.skirt, offset);
  }
  return all;
}

}  // namespace hoodoo::glb
