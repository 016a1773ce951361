#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "tiling/surface/surface.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::surface {

/// The planes of a few sheets, to be solved together: one sheet per lane.
struct SheetLanes {
  static constexpr std::size_t most = 64, most_planes = 12;
  /// t and the unit normal of a crossing.
  using Plane = std::array<float, 4>;
  alignas(64) Plane plane[most_planes][most] = {};
  alignas(64) std::int32_t edge[most_planes][most] = {};  // on which it lies, as edge_code has it
  alignas(64) double count[most] = {};                    // of planes, at least 1
  alignas(64) std::int32_t corner[3][most] = {};          // low one of the sheet's cell [steps]
  std::uint32_t number[most] = {};                        // of the vertex
  std::uint64_t further = 0;  // one bit per lane: its cell is that of the lane before
  // What solve finds.
  alignas(64) double mean[3][most] = {};  // of the crossings, in the frame of the cell
  Point point[most] = {};                 // the vertex, snapped
};
/// Where edge `edge` of a cell begins, one bit per axis, and from bit 3 on the axis it runs along.
std::int32_t edge_code(unsigned edge);
/// For the first n sheets the bits of mean_point, and snap of it plus minimise.
void solve(SheetLanes& sheets, std::size_t n, int units);

/// The meshed cells that the surface passes: bit x of row 16 z + y.
void find_active(const volume::Volume::Rows& solid, const volume::Volume::MeshedRows& meshed,
                 std::array<std::uint16_t, 256>& active);

/// A row of 16 cells along x, and the crossings on their edges.
struct CellRow {
  /// Lattice edges of one axis whose low ends lie in one row: those that are crossed, the first of
  /// their crossings, and that of the first edge beyond the sixteen.
  struct Edges {
    unsigned crossed;
    const volume::Crossing *own, *next;
  };
  std::array<std::array<Edges, 4>, 3> edges;  // by axis, and by offset in y (bit 0) and z (bit 1)
  std::array<std::uint32_t, 4> solid;         // signs of 17 points, likewise
  Point corner;                               // of the first cell [steps]
  unsigned mask(unsigned x) const {
    return (solid[0] >> x & 3) | (solid[1] >> x & 3) << 2 | (solid[2] >> x & 3) << 4 |
           (solid[3] >> x & 3) << 6;
  }
  /// Cells whose four low corners alone are solid, one bit each: most, on gentle ground.
  unsigned flat() const {
    const auto low = solid[0] & solid[1], high = solid[2] | solid[3];
    return low & low >> 1 & ~(high | high >> 1) & 0xffffU;
  }
};
/// The vertices of active cells that are `flat`, from the tile's corner: the bits of solve, found
/// without lanes to gather planes in, since neighbours share their crossings.
void solve_flat(const CellRow& row, unsigned flat, int units, std::array<Point, 16>& points);
/// Puts the sheets of `active` cells into lanes from `lane` on, in order, their numbers from
/// `vertex` on to `vertices`, until the lanes are full or a cell comes whose mask leaves it no one
/// sheet for sure. Says which cells are left.
unsigned gather(const CellRow& row, unsigned active, int units, SheetLanes& sheets,
                std::size_t& lane, std::uint32_t vertex, std::uint32_t* vertices);
/// Puts the crossings of cell x on `edges` into a lane.
void gather(const CellRow& row, unsigned x, unsigned edges, int units, SheetLanes& sheets,
            std::size_t lane);

/// Quadrilaterals around lattice edges of one axis, to be cut together.
struct QuadLanes {
  static constexpr std::size_t most = 64;
  alignas(64) std::array<std::uint32_t, 4> corner[most] = {};  // counter-clockwise about the axis
  const volume::Crossing* crossing[most] = {};                 // of the edge
  alignas(64) float sign[most] = {};  // +1: the edge's low end is solid, -1
  // What cut finds: the corner, 0 or 1, at which the diagonal begins.
  alignas(64) std::int32_t diagonal[most] = {};
};
/// The diagonal whose triangles both run counter-clockwise about the edge, which at least one does,
/// since the corners lie in successive quadrants around it. If both, the one whose triangles agree
/// better with the normal of the crossing. Four numbers are read at each corner's point, so that no
/// corner may be the last of `points`.
void cut(QuadLanes& quads, std::size_t n, int axis, const Point* points);
/// The two triangles of each of the first n, once they are cut: 2 n, and one more to be written
/// over.
void divide(const QuadLanes& quads, std::size_t n, std::array<std::uint32_t, 3>* triangles);

}  // namespace hoodoo::surface
