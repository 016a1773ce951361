#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <utility>

#include "tiling/surface/borders.hpp"
#include "tiling/surface/cells.hpp"
#include "tiling/surface/lanes.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::surface {
namespace {

using volume::Index;

/// The four cells around a lattice edge, in the order of the quadrants (--), (+-), (++), (-+) of
/// the two axes after the edge's.
struct Ring {
  std::array<Index, 4> cells;
  unsigned inside = 0;    // quadrants that are part of this surface, one bit each
  unsigned in_world = 0;  // those of which some box's surface may be
};
constexpr std::array<int, 4> quadrant_u{-1, 0, 0, -1}, quadrant_v{-1, -1, 0, 0};
constexpr unsigned all_quadrants = 0b1111;

bool has(unsigned quadrants, std::size_t q) { return (quadrants >> (q & 3) & 1) != 0; }

/// A straight border or none passes through the edge.
bool is_straight(unsigned quadrants) {
  return quadrants == all_quadrants || quadrants == 0b0011 || quadrants == 0b0110 ||
         quadrants == 0b1100 || quadrants == 0b1001;
}

/// Walks the crossed edges of a volume and makes the polygon dual to each.
class Mesher {
 public:
  Mesher(const volume::Volume& volume, int units, Surface& out)
      : volume_(volume), out_(out), cells_(volume, units, out), borders_(volume, units, out) {}

  /// Polygons of all crossed edges, block by block, in the order of their crossings.
  void run() {
    const auto& from = volume_.block_low();
    const auto& to = volume_.block_high();
    std::size_t crossings = 0;
    for_each_block(from, to,
                   [&](const Index&, const Block& b) { crossings += b.crossings.size(); });
    out_.triangles.reserve(2 * crossings);
    out_.materials.reserve(2 * crossings);
    for_each_block(from, to, [&](const Index& b, const Block& block) {
      if (!block.crossings.empty()) add_block(b, block);
    });
  }

 private:
  struct Edge {
    int axis;
    Index low;
    int sign;  // +1: the low end is solid
    const volume::Crossing* crossing;
  };
  using Block = volume::Block;
  /// The groups of the cells around a block's edges: its own and those before it, null where no
  /// cell is active. Bit a of an index: before along axis a.
  using Groups = std::array<const Cells::Group*, 8>;

  template <class Visit>
  void for_each_block(const Index& from, const Index& to, Visit visit) const {
    for (std::int64_t z = from[2]; z < to[2]; ++z) {
      for (std::int64_t y = from[1]; y < to[1]; ++y) {
        for (std::int64_t x = from[0]; x < to[0]; ++x) {
          const Index b{x, y, z};
          if (const Block* block = volume_.block(b)) visit(b, *block);
        }
      }
    }
  }

  Groups groups_around(const Index& b) const {
    Groups groups{};
    const auto& low = volume_.block_low();
    for (std::size_t part = 0; part < 8; ++part) {
      const Index at{b[0] - static_cast<int>(part & 1), b[1] - static_cast<int>(part >> 1 & 1),
                     b[2] - static_cast<int>(part >> 2)};
      const bool covered = at[0] >= low[0] && at[1] >= low[1] && at[2] >= low[2];
      if (covered) groups[part] = cells_.group(at);
    }
    return groups;
  }

  /// Edges of a row all four of whose cells are part of this surface, one bit each.
  unsigned inner_edges(std::size_t axis, const volume::Volume::MeshedRows& meshed, std::size_t y,
                       std::int64_t z) const {
    if (z >= volume_.high()[2] || (axis != 2 && z <= volume_.low()[2])) return 0;
    std::uint32_t all = meshed[y + 1] >> 1;
    if (axis != 1) all &= meshed[y] >> 1;
    if (axis != 0) all &= meshed[y + 1];
    if (axis == 2) all &= meshed[y];
    return all & 0xffffU;
  }

  void add_block(const Index& b, const Block& block) {
    const Groups groups = groups_around(b);
    const auto& meshed = volume_.meshed_rows(b[0], b[1]);
    const volume::Crossing* crossing = block.crossings.data();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t r = 0; r < 256; ++r) {
        unsigned bits = block.crossed[axis][r];
        if (bits == 0) continue;
        Index low{0, 16 * b[1] + static_cast<int>(r & 15), 16 * b[2] + static_cast<int>(r >> 4)};
        const unsigned inner = inner_edges(axis, meshed, r & 15, low[2]);
        for (; bits != 0; bits &= bits - 1, ++crossing) {
          const int x = std::countr_zero(bits);
          low[0] = 16 * b[0] + x;
          const int sign = (block.solid[r] >> x & 1) != 0 ? 1 : -1;
          const Edge edge{static_cast<int>(axis), low, sign, crossing};
          if ((inner >> x & 1) != 0) {
            add_inner(edge, groups);
          } else {
            place_quads(edge.axis);
            add_polygons(edge);
          }
        }
      }
      place_quads(static_cast<int>(axis));
    }
  }

  void add_polygons(const Edge& edge) {
    const Ring ring = ring_around(edge.axis, edge.low);
    // On a corner of the border the polygon has a corner too. Boxes that share this edge see the
    // same quadrants of the world, so they agree on it.
    const bool has_corner = !is_straight(ring.inside) || !is_straight(ring.in_world);
    for (std::size_t q = 0; q < 4; ++q) {
      if (has(ring.inside, q) && !has(ring.inside, q + 3)) add_run(edge, ring, q, has_corner);
    }
  }

  /// Corners of a polygon, counter-clockwise about the axis of its edge. The point of the edge
  /// itself, where there is one, comes last.
  struct Polygon {
    std::array<std::uint32_t, 6> corners{};
    std::size_t count = 0;
    void add(std::uint32_t vertex) { corners[count++] = vertex; }
  };

  Ring ring_around(int axis, const Index& low) const {
    Ring ring;
    const auto a = static_cast<std::size_t>(axis);
    for (std::size_t q = 0; q < 4; ++q) {
      Index& cell = ring.cells[q];
      cell = low;
      cell[next_axis(a)] += quadrant_u[q];
      cell[last_axis(a)] += quadrant_v[q];
      if (cells_.inside(cell)) ring.inside |= 1U << q;
    }
    if (ring.inside == all_quadrants) return ring;
    for (std::size_t q = 0; q < 4; ++q) {
      if (volume_.in_world(ring.cells[q][0], ring.cells[q][1])) ring.in_world |= 1U << q;
    }
    return ring;
  }

  std::uint32_t cell_vertex(const Edge& edge, const Ring& ring, std::size_t q) const {
    const auto offset = static_cast<unsigned>(-quadrant_u[q & 3] - 2 * quadrant_v[q & 3]);
    return cells_.vertex(ring.cells[q & 3], 4 * static_cast<unsigned>(edge.axis) + offset);
  }

  /// The vertex on the face between quadrants `q` and `q` + 1, one of them inside.
  std::uint32_t face_vertex(const Edge& edge, const Ring& ring, std::size_t q) {
    q &= 3;
    const auto a = static_cast<std::size_t>(edge.axis);
    const std::size_t across = q % 2 == 0 ? next_axis(a) : last_axis(a);
    // Before quadrants 1 and 0 the face lies below the edge, which is then on its high side.
    const bool on_high_side = q == 0 || q == 3;
    Face face{across, edge.low};
    if (on_high_side) --face.low[q == 0 ? last_axis(a) : next_axis(a)];
    const int k = a == next_axis(across) ? (on_high_side ? 2 : 0) : (on_high_side ? 1 : 3);
    const bool edge_of_world = !has(ring.in_world, q) || !has(ring.in_world, q + 1);
    return borders_.face_vertex(face, k, edge_of_world ? world_edge : 0);
  }

  /// The quadrilateral of four cells; it waits for its diagonal.
  void add_inner(const Edge& edge, const Groups& groups) {
    const auto a = static_cast<std::size_t>(edge.axis);
    const std::size_t lane = waiting_count_++;
    Waiting& quad = waiting_[lane];
    quad.edge = edge;
    for (std::size_t q = 0; q < 4; ++q) {
      Index cell = edge.low;
      std::size_t part = 0;
      const auto before = [&](std::size_t axis, int offset) {
        if (offset < 0 && (cell[axis]-- & 15) == 0) part |= std::size_t{1} << axis;
      };
      before(next_axis(a), quadrant_u[q]);
      before(last_axis(a), quadrant_v[q]);
      const auto number = static_cast<unsigned>(-quadrant_u[q] - 2 * quadrant_v[q]);
      const auto vertex = cells_.vertex(*groups[part], cell, 4 * static_cast<unsigned>(a) + number);
      quad.corners[q] = vertex;
      for (std::size_t d = 0; d < 3; ++d) lanes_.corner[q][d][lane] = out_.points[vertex][d];
    }
    const auto& n = edge.crossing->normal;
    lanes_.wanted[0][lane] = n.x;
    lanes_.wanted[1][lane] = n.y;
    lanes_.wanted[2][lane] = n.z;
    lanes_.sign[lane] = static_cast<float>(edge.sign);
    if (waiting_count_ == QuadLanes::most) place_quads(edge.axis);
  }

  /// Those that wait are all around edges along `axis`.
  void place_quads(int axis) {
    if (waiting_count_ == 0) return;
    cut(lanes_, waiting_count_, axis);
    for (std::size_t i = 0; i < waiting_count_; ++i) {
      add_quad(waiting_[i].edge, waiting_[i].corners, lanes_.diagonal[i]);
    }
    waiting_count_ = 0;
  }

  /// The polygon of the quadrants inside from `first` on.
  void add_run(const Edge& edge, const Ring& ring, std::size_t first, bool has_corner) {
    Polygon polygon;
    polygon.add(face_vertex(edge, ring, first + 3));
    std::size_t q = first;
    for (; has(ring.inside, q); ++q) polygon.add(cell_vertex(edge, ring, q));
    polygon.add(face_vertex(edge, ring, q - 1));
    if (has_corner) {
      const std::uint8_t marks = ring.in_world == all_quadrants ? 0 : world_edge;
      polygon.add(borders_.crossing_vertex(edge.axis, edge.low, marks));
    }
    assert(polygon.count >= 4);
    if (polygon.count == 4) {
      add_lone_quad(edge, polygon);
      return;
    }
    // The edge's own point sees every other corner: each lies in the quadrant after the one before.
    const std::uint32_t hub = polygon.corners[polygon.count - 1];
    for (std::size_t i = 0; i + 2 < polygon.count; ++i) {
      add_triangle(edge, hub, polygon.corners[i], polygon.corners[i + 1]);
    }
  }

  void add_lone_quad(const Edge& edge, const Polygon& polygon) {
    for (std::size_t q = 0; q < 4; ++q) {
      const auto& p = out_.points[polygon.corners[q]];
      for (std::size_t d = 0; d < 3; ++d) lanes_.corner[q][d][0] = p[d];
    }
    const auto& n = edge.crossing->normal;
    lanes_.wanted[0][0] = n.x;
    lanes_.wanted[1][0] = n.y;
    lanes_.wanted[2][0] = n.z;
    lanes_.sign[0] = static_cast<float>(edge.sign);
    cut(lanes_, 1, edge.axis);
    const auto& c = polygon.corners;
    add_quad(edge, {c[0], c[1], c[2], c[3]}, lanes_.diagonal[0]);
  }

  void add_triangle(const Edge& edge, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (edge.sign < 0) std::swap(b, c);
    out_.triangles.push_back({a, b, c});
    out_.materials.push_back(edge.crossing->material);
  }

  void add_quad(const Edge& edge, const std::array<std::uint32_t, 4>& c, int diagonal) {
    if (diagonal == 0) {
      add_triangle(edge, c[0], c[1], c[2]);
      add_triangle(edge, c[0], c[2], c[3]);
    } else {
      add_triangle(edge, c[1], c[2], c[3]);
      add_triangle(edge, c[1], c[3], c[0]);
    }
  }

  const volume::Volume& volume_;
  Surface& out_;
  Cells cells_;
  Borders borders_;
  struct Waiting {
    Edge edge;
    std::array<std::uint32_t, 4> corners;
  };
  std::array<Waiting, QuadLanes::most> waiting_;
  QuadLanes lanes_;
  std::size_t waiting_count_ = 0;
};

}  // namespace

Surface polygonize(const volume::Volume& volume, int units,
                   const std::function<void(std::span<Point>)>& settle) {
  assert(units >= 256);
  Surface surface;
  Mesher mesher(volume, units, surface);
  if (settle) settle(surface.points);
  mesher.run();
  return surface;
}

}  // namespace hoodoo::surface
