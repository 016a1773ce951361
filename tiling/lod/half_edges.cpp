#include "tiling/lod/half_edges.hpp"

#include <algorithm>

namespace hoodoo::lod {

HalfEdges::HalfEdges(std::span<const Triangle> triangles, std::size_t vertices)
    : first_(vertices + 1), edges_(3 * triangles.size()) {
  for (const auto& triangle : triangles) {
    for (const auto vertex : triangle) ++first_[vertex + 1];
  }
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto& corner = triangles[t];
    for (std::size_t c = 0; c < 3; ++c) {
      edges_[next[corner[c]]++] = {corner[(c + 1) % 3], corner[(c + 2) % 3], t};
    }
  }
}

namespace {

/// Number of fans that the triangles around a vertex form, when no half-edge is doubled: each
/// triangle is followed by the one whose half-edge goes to its apex.
std::uint32_t count_fans(std::span<const HalfEdges::HalfEdge> around) {
  const std::size_t n = around.size();
  std::vector<bool> seen(n);
  const auto find = [&](auto matches) {
    return static_cast<std::size_t>(std::ranges::find_if(around, matches) - around.begin());
  };
  const auto follow = [&](std::size_t at) {
    for (; at < n && !seen[at];) {
      seen[at] = true;
      const auto apex = around[at].apex;
      at = find([&](const auto& edge) { return edge.to == apex; });
    }
  };
  std::uint32_t fans = 0;
  for (std::size_t i = 0; i < n; ++i) {  // open fans, from their first triangle
    if (find([&](const auto& edge) { return edge.apex == around[i].to; }) < n) continue;
    ++fans;
    follow(i);
  }
  for (std::size_t i = 0; i < n; ++i) {  // closed ones
    if (seen[i]) continue;
    ++fans;
    follow(i);
  }
  return fans;
}

/// True when the triangles around an inner vertex close up in one round, walked without memory:
/// the common case.
bool one_closed_fan(std::span<const HalfEdges::HalfEdge> around) {
  std::uint32_t apex = around.front().apex;
  std::size_t steps = 1;
  for (; apex != around.front().to; ++steps) {
    if (steps == around.size()) return false;
    const auto next = std::ranges::find_if(around, [&](const auto& e) { return e.to == apex; });
    if (next == around.end()) return false;
    apex = next->apex;
  }
  return steps == around.size();
}

}  // namespace

Topology topology(std::span<const Triangle> triangles, const HalfEdges& edges) {
  Topology result;
  for (const auto& t : triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) result.faulty.push_back(t[0]);
  }
  std::int64_t used = 0, edge_count = 0;
  for (std::uint32_t v = 0; v < edges.vertices(); ++v) {
    const auto around = edges.from(v);
    if (around.empty()) continue;
    ++used;
    // In one round each half-edge out has one back in, and with three triangles no two are on the
    // same vertices.
    if (around.size() > 2 && one_closed_fan(around)) {
      edge_count += std::ranges::count_if(around, [&](const auto& edge) { return v < edge.to; });
      continue;
    }
    for (const auto& edge : around) {
      if (edges.find(v, edge.to) != &edge) result.faulty.push_back(v);
      const auto* partner = edges.find(edge.to, v);
      if (partner == nullptr) {
        result.open.push_back({v, edge.to, edge.triangle});
        ++edge_count;
      } else if (v < edge.to) {
        if (partner->apex == edge.apex) result.faulty.push_back(v);
        ++edge_count;
      }
    }
    const auto fans = count_fans(around);
    if (fans != 1) result.split.push_back({v, fans});
  }
  std::ranges::sort(result.open);
  result.euler = used - edge_count + static_cast<std::int64_t>(triangles.size());
  return result;
}

}  // namespace hoodoo::lod
