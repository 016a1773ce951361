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
  Mesher(const volume::Volume& volume, int units, Workspace& workspace)
      : volume_(volume),
        out_(workspace.surface),
        cells_(volume, units, workspace),
        borders_(volume, units, out_.points.size(), rim_) {}

  /// Polygons of all crossed edges, block by block, in the order of their crossings.
  void run() {
    const auto& from = volume_.block_low();
    const auto& to = volume_.block_high();
    std::size_t crossings = 0;
    for_each_block(from, to,
                   [&](const Index&, const Block& b) { crossings += b.crossings.size(); });
    out_.triangles.reserve(2 * crossings);
    out_.materials.reserve(2 * crossings);
    out_.points.emplace_back();  // no vertex: what `cut` reads of one ends within the next
    for_each_block(from, to, [&](const Index& b, const Block& block) {
      if (!block.crossings.empty()) add_block(b, block);
    });
    out_.points.pop_back();
    out_.points.insert(out_.points.end(), rim_.points.begin(), rim_.points.end());
    out_.planes.insert(out_.planes.end(), rim_.planes.begin(), rim_.planes.end());
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
  using Groups = std::array<const CellGroup*, 8>;

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
      block.for_each_row(axis, [&](std::size_t r) {
        unsigned bits = block.crossed[axis][r];
        Index low{16 * b[0], 16 * b[1] + static_cast<int>(r & 15),
                  16 * b[2] + static_cast<int>(r >> 4)};
        const unsigned inner = inner_edges(axis, meshed, r & 15, low[2]);
        const auto around = cells_around(groups, axis, r);
        for (; bits != 0; bits &= bits - 1, ++crossing) {
          const int x = std::countr_zero(bits);
          const int sign = (block.solid[r] >> x & 1) != 0 ? 1 : -1;
          if ((inner >> x & 1) != 0) {
            add_inner(around, static_cast<int>(axis), static_cast<std::size_t>(x), sign, crossing);
          } else {
            place_quads(static_cast<int>(axis));
            low[0] = 16 * b[0] + x;
            add_polygons({static_cast<int>(axis), low, sign, crossing});
          }
        }
      });
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

  /// The cells in one quadrant around a row of edges.
  struct CellsBeside {
    const CellGroup *own, *before;  // of those around the first edge, where it is another
    std::size_t place;              // in them, of the cells beside the first edge
    const std::uint32_t* row;       // the vertices of `own` from there on
    std::size_t step;               // 1: the cell beside edge x is the one before
    unsigned edge;                  // the number of these edges in their cells
  };
  using Around = std::array<CellsBeside, 4>;

  static Around cells_around(const Groups& groups, std::size_t axis, std::size_t row) {
    Around around;
    for (std::size_t q = 0; q < 4; ++q) {
      std::array<int, 3> at{0, static_cast<int>(row & 15), static_cast<int>(row >> 4)};
      at[next_axis(axis)] += quadrant_u[q];
      at[last_axis(axis)] += quadrant_v[q];
      const std::size_t part = (at[1] < 0 ? 2U : 0U) + (at[2] < 0 ? 4U : 0U);
      const auto place = static_cast<std::size_t>((at[2] & 15) * 256 + (at[1] & 15) * 16);
      around[q] = {groups[part],
                   groups[part + 1],
                   place,
                   groups[part] != nullptr ? &groups[part]->vertex[place] : nullptr,
                   at[0] < 0 ? 1U : 0U,
                   4 * static_cast<unsigned>(axis) +
                       static_cast<unsigned>(-quadrant_u[q] - 2 * quadrant_v[q])};
    }
    return around;
  }

  /// The quadrilateral of four cells; it waits for its diagonal.
  void add_inner(const Around& around, int axis, std::size_t x, int sign,
                 const volume::Crossing* crossing) {
    const std::size_t lane = waiting_++;
    auto& corner = quads_.corner[lane];
    std::uint32_t any = 0;
    for (std::size_t q = 0; q < 4; ++q) {
      const CellsBeside& cells = around[q];
      const bool first = x < cells.step;
      corner[q] = first ? cells.before->vertex[cells.place + 15] : cells.row[x - cells.step];
      any |= corner[q];
    }
    if ((any & CellGroup::several) != 0) {
      for (std::size_t q = 0; q < 4; ++q) {
        const CellsBeside& cells = around[q];
        const bool first = x < cells.step;
        corner[q] = cells_.vertex(first ? *cells.before : *cells.own,
                                  cells.place + (first ? 15 : x - cells.step), cells.edge);
      }
    }
    quads_.crossing[lane] = crossing;
    quads_.sign[lane] = static_cast<float>(sign);
    if (waiting_ == QuadLanes::most) place_quads(axis);
  }

  /// Those that wait are all around edges along `axis`.
  void place_quads(int axis) {
    if (waiting_ == 0) return;
    cut(quads_, waiting_, axis, out_.points.data());
    std::array<std::array<std::uint32_t, 3>, 2 * QuadLanes::most + 1> triangles;
    std::array<std::uint16_t, 2 * QuadLanes::most> materials;
    divide(quads_, waiting_, triangles.data());
    for (std::size_t i = 0; i < waiting_; ++i) {
      materials[2 * i] = materials[2 * i + 1] = quads_.crossing[i]->material;
    }
    const auto n = static_cast<std::ptrdiff_t>(2 * waiting_);
    out_.triangles.insert(out_.triangles.end(), triangles.begin(), triangles.begin() + n);
    out_.materials.insert(out_.materials.end(), materials.begin(), materials.begin() + n);
    waiting_ = 0;
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
    std::array<Point, 5> points{};
    for (std::uint32_t q = 0; q < 4; ++q) {
      points[q] = point(polygon.corners[q]);
      quads_.corner[0][q] = q;
    }
    quads_.crossing[0] = edge.crossing;
    quads_.sign[0] = static_cast<float>(edge.sign);
    cut(quads_, 1, edge.axis, points.data());
    for (std::size_t q = 0; q < 4; ++q) quads_.corner[0][q] = polygon.corners[q];
    std::array<std::array<std::uint32_t, 3>, 3> triangles;
    divide(quads_, 1, triangles.data());
    out_.triangles.insert(out_.triangles.end(), triangles.begin(), triangles.begin() + 2);
    out_.materials.insert(out_.materials.end(), 2, edge.crossing->material);
  }

  const Point& point(std::uint32_t vertex) const {
    const std::size_t inner = out_.points.size() - 1;
    return vertex < inner ? out_.points[vertex] : rim_.points[vertex - inner];
  }

  void add_triangle(const Edge& edge, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (edge.sign < 0) std::swap(b, c);
    out_.triangles.push_back({a, b, c});
    out_.materials.push_back(edge.crossing->material);
  }

  const volume::Volume& volume_;
  Surface& out_;
  Surface rim_;  // the vertices of the borders, which come last
  Cells cells_;
  Borders borders_;
  QuadLanes quads_;
  std::size_t waiting_ = 0;
};

}  // namespace

Surface polygonize(const volume::Volume& volume, int units,
                   const std::function<void(std::span<Point>)>& settle) {
  Workspace workspace;
  polygonize(volume, units, workspace, settle);
  return std::move(workspace.surface);
}

const Surface& polygonize(const volume::Volume& volume, int units, Workspace& workspace,
                          const std::function<void(std::span<Point>)>& settle) {
  assert(units >= 256);
  Surface& surface = workspace.surface;
  surface.points.clear(), surface.planes.clear();
  surface.triangles.clear(), surface.materials.clear();
  Mesher mesher(volume, units, workspace);
  if (settle) settle(surface.points);
  mesher.run();
  return surface;
}

Workspace::Workspace() = default;
Workspace::~Workspace() = default;

}  // namespace hoodoo::surface
