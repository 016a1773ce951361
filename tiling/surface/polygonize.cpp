#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "tiling/surface/borders.hpp"
#include "tiling/surface/cells.hpp"
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

  void add_polygons(int axis, const Index& low) {
    const Ring ring = ring_around(axis, low);
    const Edge edge{axis, low, volume_.solid(low) ? 1 : -1, &volume_.crossing(axis, low)};
    if (ring.inside == all_quadrants) {
      add_inner(edge, ring);
      return;
    }
    // On a corner of the border the polygon has a corner too. Boxes that share this edge see the
    // same quadrants of the world, so they agree on it.
    const bool has_corner = !is_straight(ring.inside) || !is_straight(ring.in_world);
    for (std::size_t q = 0; q < 4; ++q) {
      if (has(ring.inside, q) && !has(ring.inside, q + 3)) add_run(edge, ring, q, has_corner);
    }
  }

 private:
  struct Edge {
    int axis;
    Index low;
    int sign;  // +1: the low end is solid
    const volume::Crossing* crossing;
  };
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

  void add_inner(const Edge& edge, const Ring& ring) {
    std::array<std::uint32_t, 4> corners;
    for (std::size_t q = 0; q < 4; ++q) corners[q] = cell_vertex(edge, ring, q);
    add_quad(edge, corners);
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
      const auto& c = polygon.corners;
      add_quad(edge, {c[0], c[1], c[2], c[3]});
      return;
    }
    // The edge's own point sees every other corner: each lies in the quadrant after the one before.
    const std::uint32_t hub = polygon.corners[polygon.count - 1];
    for (std::size_t i = 0; i + 2 < polygon.count; ++i) {
      add_triangle(edge, hub, polygon.corners[i], polygon.corners[i + 1]);
    }
  }

  void add_triangle(const Edge& edge, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (edge.sign < 0) std::swap(b, c);
    out_.triangles.push_back({a, b, c});
    out_.materials.push_back(edge.crossing->material);
  }

  void add_quad(const Edge& edge, const std::array<std::uint32_t, 4>& c) {
    if (better_diagonal(edge, c) == 0) {
      add_triangle(edge, c[0], c[1], c[2]);
      add_triangle(edge, c[0], c[2], c[3]);
    } else {
      add_triangle(edge, c[1], c[2], c[3]);
      add_triangle(edge, c[1], c[3], c[0]);
    }
  }

  /// Normal of a triangle that is counter-clockwise about the edge's axis, turned out of the solid.
  Vec3 normal(const Edge& edge, std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const auto& p = out_.points[a];
    const auto from = [&](std::uint32_t v) {
      const auto& q = out_.points[v];
      return Vec3{static_cast<double>(q[0] - p[0]), static_cast<double>(q[1] - p[1]),
                  static_cast<double>(q[2] - p[2])};
    };
    return cross(from(b), from(c)) * edge.sign;
  }

  /// The diagonal from corner 0 or 1: one whose triangles both run counter-clockwise about the
  /// edge, which at least one does, since the corners lie in successive quadrants around it. If
  /// both, the one whose triangles agree better with the normal of the crossing.
  std::size_t better_diagonal(const Edge& edge, const std::array<std::uint32_t, 4>& c) const {
    const auto& n = edge.crossing->normal;
    const Vec3 wanted{n.x, n.y, n.z};
    std::array<double, 2> agreement;
    for (std::size_t d = 0; d < 2; ++d) {
      const Vec3 first = normal(edge, c[d], c[d + 1], c[(d + 2) & 3]);
      const Vec3 second = normal(edge, c[d], c[(d + 2) & 3], c[(d + 3) & 3]);
      // Coordinates are whole steps within two cells, so these areas are exact.
      if (!(first[edge.axis] * edge.sign > 0 && second[edge.axis] * edge.sign > 0)) return 1 - d;
      agreement[d] =
          std::min(dot(first, wanted) / length(first), dot(second, wanted) / length(second));
    }
    return agreement[0] >= agreement[1] ? 0 : 1;
  }

  const volume::Volume& volume_;
  Surface& out_;
  Cells cells_;
  Borders borders_;
};

}  // namespace

Surface polygonize(const volume::Volume& volume, int units,
                   const std::function<void(std::span<Point>)>& settle) {
  assert(units >= 256);
  Surface surface;
  Mesher mesher(volume, units, surface);
  if (settle) settle(surface.points);
  volume.for_each_crossing([&](int axis, const Index& low) { mesher.add_polygons(axis, low); });
  return surface;
}

}  // namespace hoodoo::surface
