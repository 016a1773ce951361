#include "tiling/tileset/seams.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "engine/base/random.hpp"
#include "tiling/lod/half_edges.hpp"

namespace hoodoo::tileset {

/// One tile's surface with a vertex per position.
struct Seams::Welded {
  std::vector<Position> points;
  std::vector<Vec3f> normals;
  std::vector<lod::Triangle> triangles;
};

const char* Seams::describe(Kind kind) {
  switch (kind) {
    case degenerate:
      return "triangles without area";
    case doubled:
      return "triangles doubled or edges with two faces on one side";
    case off_plane:
      return "edges with one face in no plane between cells";
    case overfull:
      return "edges in a border plane with more than two faces";
    case normals:
      return "vertices at one position with different normals";
    case outside:
      return "points outside their tile";
    case kinds:
      break;
  }
  return "";
}

std::size_t Seams::Hash::operator()(const Position& p) const {
  return random_bits(static_cast<std::uint64_t>(p[0]), p[1], p[2]);
}
std::size_t Seams::Hash::operator()(const EdgeKey& e) const {
  return mix((*this)(e.low) + 3 * (*this)(e.high));
}

void Seams::blame(Kind kind, const Position& where) {
  auto& fault = faults_[kind];
  const double step = lattice_.step(level_);
  const auto metres = [&](std::size_t a) { return static_cast<double>(where[a]) * step; };
  if (fault.count++ == 0)
    fault.where = fmt::format("({}, {}, {})", metres(0), metres(1), metres(2));
}

bool Seams::in_cell_plane(const Position& a, const Position& b) const {
  const std::int64_t units = lattice_.units();
  return (a[0] == b[0] && a[0] % units == 0) || (a[1] == b[1] && a[1] % units == 0);
}

bool Seams::in_border_plane(const Position& a, const Position& b) const {
  const std::int64_t side = lattice_.side(level_);
  return (a[0] == b[0] && a[0] % side == 0) || (a[1] == b[1] && a[1] % side == 0);
}

Seams::Welded Seams::weld(const glb::Decoded& tile) {
  const auto& part = tile.surface;
  std::vector<std::uint32_t> order(part.points.size()), name(part.points.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, [&](auto a, auto b) {
    return std::tie(part.points[a], a) < std::tie(part.points[b], b);
  });
  Welded welded;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& p = part.points[order[i]];
    if (i == 0 || p != part.points[order[i - 1]]) {
      welded.points.push_back(
          {tile.origin[0] + p[0], tile.origin[1] + p[1], tile.origin[2] + p[2]});
      welded.normals.push_back(part.normals[order[i]]);
    } else if (welded.normals.back() != part.normals[order[i]]) {
      blame(normals, welded.points.back());
    }
    name[order[i]] = static_cast<std::uint32_t>(welded.points.size() - 1);
  }
  for (const auto& [a, b, c] : part.triangles) {
    welded.triangles.push_back({name[a], name[b], name[c]});
    const auto vector = [&](std::uint32_t from, std::uint32_t to) {
      const auto &p = part.points[from], &q = part.points[to];
      return Vec3{static_cast<double>(q[0]) - p[0], static_cast<double>(q[1]) - p[1],
                  static_cast<double>(q[2]) - p[2]};
    };
    if (cross(vector(a, b), vector(a, c)) == Vec3{}) {
      blame(degenerate, welded.points[name[a]]);
    }
  }
  return welded;
}

void Seams::add_vertices(const Welded& welded) {
  for (std::size_t i = 0; i < welded.points.size(); ++i) {
    const auto& p = welded.points[i];
    if (!on_border(p)) {
      ++vertices_;
      continue;
    }
    const auto entry = border_normals_.try_emplace(p, welded.normals[i]);
    if (entry.second) {
      ++vertices_;
      ++border_vertices_;
    } else if (entry.first->second != welded.normals[i]) {
      blame(normals, p);
    }
  }
}

void Seams::add_border_edge(const Position& from, const Position& to) {
  const bool up = from < to;
  auto& sides = border_edges_[up ? EdgeKey{from, to} : EdgeKey{to, from}];
  ++(up ? sides.up : sides.down);
}

void Seams::add_edges(const Welded& welded) {
  const lod::HalfEdges edges(welded.triangles, welded.points.size());
  const auto topology = lod::topology(welded.triangles, edges);
  for (const auto vertex : topology.faulty) blame(doubled, welded.points[vertex]);
  for (std::uint32_t v = 0; v < welded.points.size(); ++v) {
    const auto& from = welded.points[v];
    for (const auto& edge : edges.from(v)) {
      const auto& to = welded.points[edge.to];
      if (in_border_plane(from, to)) {
        add_border_edge(from, to);
      } else if (edges.find(edge.to, v) == nullptr) {
        ++edges_;
        ++open_edges_;
        if (!in_cell_plane(from, to)) blame(off_plane, from);
      } else if (v < edge.to) {
        ++edges_;
      }
    }
  }
}

void Seams::add(const plan::Key& key, const glb::Decoded& tile) {
  const std::int64_t side = lattice_.side(level_);
  if (key.y != row_) close_below(key.y * side);
  row_ = key.y;
  const Welded welded = weld(tile);
  for (const auto& p : welded.points) {
    if (p[0] < key.x * side || p[0] > (key.x + 1) * side || p[1] < key.y * side ||
        p[1] > (key.y + 1) * side) {
      blame(outside, p);
    }
  }
  faces_ += static_cast<std::int64_t>(welded.triangles.size());
  add_vertices(welded);
  add_edges(welded);
}

/// Counts and forgets what lies below `y` [steps]: no further tile reaches there.
void Seams::close_below(std::int64_t y) {
  std::erase_if(border_normals_, [&](const auto& entry) { return entry.first[1] < y; });
  std::erase_if(border_edges_, [&](const auto& entry) {
    const auto& [edge, sides] = entry;
    if (std::min(edge.low[1], edge.high[1]) >= y) return false;
    ++edges_;
    if (sides.up + sides.down == 1) ++open_edges_;
    if (sides.up > 1 || sides.down > 1) blame(overfull, edge.low);
    return true;
  });
}

void Seams::finish() { close_below(std::numeric_limits<std::int64_t>::max()); }

}  // namespace hoodoo::tileset
