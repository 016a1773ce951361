#include "tests/tiling/surface/topology.hpp"

#include <algorithm>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace hoodoo::surface::testing {
namespace {

/// One side of one triangle.
struct Side {
  std::uint32_t low, high;  // its ends
  bool forward;             // it runs from low to high
  std::size_t triangle;
};

/// All sides, those of one edge together.
std::vector<Side> sides_of(const Net& net) {
  std::vector<Side> sides;
  sides.reserve(3 * net.triangles.size());
  for (std::size_t t = 0; t < net.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = net.triangles[t][k], b = net.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b, t});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

/// Calls visit(first, last) for the sides of each edge.
template <class Visit>
void for_each_edge(const std::vector<Side>& sides, Visit visit) {
  for (auto from = sides.begin(), to = from; from != sides.end(); from = to) {
    while (to != sides.end() && to->low == from->low && to->high == from->high) ++to;
    visit(from, to);
  }
}

void check_edges(const Net& net, const Where& may_end, Faults& faults) {
  for_each_edge(sides_of(net), [&](auto from, auto to) {
    const auto forward = std::count_if(from, to, [](const Side& s) { return s.forward; });
    const auto backward = to - from - forward;
    if (forward > 1 || backward > 1) ++faults.crowded_edges;
    if (to - from == 1 && !(may_end(from->low) && may_end(from->high))) ++faults.open_edges;
    for (auto side = from + 1; side != to; ++side) {
      const auto t = from->triangle, u = side->triangle;
      if (net.tiles[t] != net.tiles[u] && net.materials[t] != net.materials[u]) {
        ++faults.unequal_labels;
      }
    }
  });
}

bool has_no_area(const Net& net, const std::array<std::uint32_t, 3>& t) {
  std::array<std::int64_t, 3> u, v;
  for (std::size_t d = 0; d < 3; ++d) {
    u[d] = net.points[t[1]][d] - net.points[t[0]][d];
    v[d] = net.points[t[2]][d] - net.points[t[0]][d];
  }
  return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

using Link = std::array<std::uint32_t, 2>;

/// Number of fans around a point from the edges opposite to it, -1 if some edge is used twice.
int fans(std::vector<Link> links) {
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (links[i][0] == links[j][0] || links[i][1] == links[j][1]) return -1;
    }
  }
  int count = 0;
  while (!links.empty()) {
    ++count;
    Link fan = links.back();
    links.pop_back();
    for (bool grown = true; grown;) {
      grown = false;
      for (auto& link : links) {
        if (link[0] != fan[1] && link[1] != fan[0]) continue;
        fan = link[0] == fan[1] ? Link{fan[0], link[1]} : Link{link[0], fan[1]};
        link = links.back();
        links.pop_back();
        grown = true;
        break;
      }
    }
  }
  return count;
}

using Position = std::array<std::int64_t, 3>;
struct PositionHash {
  std::size_t operator()(const Position& p) const {
    return static_cast<std::size_t>(random_bits(static_cast<std::uint64_t>(p[0]), p[1], p[2]));
  }
};

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
  std::unordered_map<Position, std::uint32_t, PositionHash> index;
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
  auto sorted = net.triangles;
  std::vector<std::vector<Link>> links(net.points.size());
  for (std::size_t i = 0; i < net.triangles.size(); ++i) {
    const auto& t = net.triangles[i];
    const bool repeats = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    if (repeats || has_no_area(net, t)) ++faults.degenerate;
    for (std::size_t k = 0; k < 3; ++k) links[t[k]].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
    std::sort(sorted[i].begin(), sorted[i].end());
  }
  std::sort(sorted.begin(), sorted.end());
  faults.doubled = sorted.end() - std::unique(sorted.begin(), sorted.end());
  check_edges(net, may_end, faults);
  for (std::uint32_t p = 0; p < net.points.size(); ++p) {
    const int count = fans(std::move(links[p]));
    if (count != 1 && !(count > 1 && may_pinch(p))) ++faults.broken_fans;
  }
  return faults;
}

long euler_characteristic(const Net& net) {
  long edges = 0;
  for_each_edge(sides_of(net), [&](auto, auto) { ++edges; });
  return static_cast<long>(net.points.size()) - edges + static_cast<long>(net.triangles.size());
}

std::ostream& operator<<(std::ostream& out, const Faults& f) {
  return out << "degenerate " << f.degenerate << ", doubled " << f.doubled << ", crowded edges "
             << f.crowded_edges << ", open edges " << f.open_edges << ", broken fans "
             << f.broken_fans << ", unequal labels " << f.unequal_labels;
}

}  // namespace hoodoo::surface::testing
