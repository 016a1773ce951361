#include "tests/tiling/surface/topology.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

namespace hoodoo::surface::testing {
namespace {

struct EdgeUse {
  int forward = 0, backward = 0;
  std::size_t first_triangle = 0;
};
using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, EdgeUse>;

Edges edges_of(const Net& net, Faults& faults) {
  Edges edges;
  for (std::size_t t = 0; t < net.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = net.triangles[t][k], b = net.triangles[t][(k + 1) % 3];
      const auto [found, is_new] = edges.try_emplace({std::min(a, b), std::max(a, b)});
      auto& use = found->second;
      if (is_new) use.first_triangle = t;
      ++(a < b ? use.forward : use.backward);
      const auto other = use.first_triangle;
      if (net.tiles[other] != net.tiles[t] && net.materials[other] != net.materials[t]) {
        ++faults.unequal_labels;
      }
    }
  }
  return edges;
}

bool has_no_area(const Net& net, const std::array<std::uint32_t, 3>& t) {
  std::array<std::int64_t, 3> u, v;
  for (std::size_t d = 0; d < 3; ++d) {
    u[d] = net.points[t[1]][d] - net.points[t[0]][d];
    v[d] = net.points[t[2]][d] - net.points[t[0]][d];
  }
  return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/// Number of fans around a point from the edges opposite to it, -1 if some edge is used twice.
int fans(const std::vector<std::array<std::uint32_t, 2>>& links) {
  std::map<std::uint32_t, std::uint32_t> next;
  std::set<std::uint32_t> has_previous;
  for (const auto& [from, to] : links) {
    if (!next.emplace(from, to).second || !has_previous.insert(to).second) return -1;
  }
  int count = 0;
  std::set<std::uint32_t> seen;
  const auto walk = [&](std::uint32_t from) {
    ++count;
    for (auto at = next.find(from); at != next.end() && seen.insert(at->first).second;) {
      at = next.find(at->second);
    }
  };
  for (const auto& [from, to] : next) {
    if (!has_previous.contains(from)) walk(from);
  }
  for (const auto& [from, to] : next) {
    if (!seen.contains(from)) walk(from);
  }
  return count;
}

}  // namespace

Net net_of(const Surface& surface, const Index& low, int units) {
  Net net;
  for (const auto& p : surface.points) {
    net.points.push_back({low[0] * units + p[0], low[1] * units + p[1], low[2] * units + p[2]});
  }
  net.planes = surface.planes;
  net.triangles = surface.triangles;
  net.materials = surface.materials;
  net.tiles.assign(net.triangles.size(), 0);
  return net;
}

Net weld(const std::vector<Net>& tiles) {
  Net welded;
  std::map<std::array<std::int64_t, 3>, std::uint32_t> index;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    std::vector<std::uint32_t> to;
    for (std::size_t i = 0; i < tiles[t].points.size(); ++i) {
      const auto next = static_cast<std::uint32_t>(welded.points.size());
      const auto [found, is_new] = index.try_emplace(tiles[t].points[i], next);
      if (is_new) {
        welded.points.push_back(tiles[t].points[i]);
        welded.planes.push_back(0);
      }
      auto& planes = welded.planes[found->second];
      planes = static_cast<std::uint8_t>(planes | tiles[t].planes[i]);
      to.push_back(found->second);
    }
    for (const auto& [a, b, c] : tiles[t].triangles)
      welded.triangles.push_back({to[a], to[b], to[c]});
    welded.materials.insert(welded.materials.end(), tiles[t].materials.begin(),
                            tiles[t].materials.end());
    welded.tiles.insert(welded.tiles.end(), tiles[t].triangles.size(), static_cast<int>(t));
  }
  return welded;
}

Faults faults_of(const Net& net, const Where& may_end, const Where& may_pinch) {
  Faults faults;
  std::set<std::array<std::uint32_t, 3>> seen;
  std::vector<std::vector<std::array<std::uint32_t, 2>>> links(net.points.size());
  for (const auto& t : net.triangles) {
    const bool repeats = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    if (repeats || has_no_area(net, t)) ++faults.degenerate;
    auto sorted = t;
    std::sort(sorted.begin(), sorted.end());
    if (!seen.insert(sorted).second) ++faults.doubled;
    for (std::size_t k = 0; k < 3; ++k) links[t[k]].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  for (const auto& [edge, use] : edges_of(net, faults)) {
    if (use.forward > 1 || use.backward > 1) ++faults.crowded_edges;
    if (use.forward + use.backward == 1 && !(may_end(edge.first) && may_end(edge.second))) {
      ++faults.open_edges;
    }
  }
  for (std::uint32_t p = 0; p < net.points.size(); ++p) {
    const int count = fans(links[p]);
    if (count != 1 && !(count > 1 && may_pinch(p))) ++faults.broken_fans;
  }
  return faults;
}

long euler_characteristic(const Net& net) {
  Faults unused;
  return static_cast<long>(net.points.size()) - static_cast<long>(edges_of(net, unused).size()) +
         static_cast<long>(net.triangles.size());
}

std::ostream& operator<<(std::ostream& out, const Faults& f) {
  return out << "degenerate " << f.degenerate << ", doubled " << f.doubled << ", crowded edges "
             << f.crowded_edges << ", open edges " << f.open_edges << ", broken fans "
             << f.broken_fans << ", unequal labels " << f.unequal_labels;
}

}  // namespace hoodoo::surface::testing
