#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "tiling/volume/volume.hpp"

/// tiling/surface: Hermite blocks -> one surface.
namespace hoodoo::surface {

/// Border planes of a tile, as bits: low and high x, y, z. `world_edge` marks a vertex on a face
/// or edge between a meshed cell and one that is not (the world's border, a NoData hole).
enum Plane : std::uint8_t {
  west = 1,
  east = 2,
  south = 4,
  north = 8,
  bottom = 16,
  top = 32,
  world_edge = 64
};

/// Steps from the low corner of a volume.
using Point = std::array<std::int32_t, 3>;

/// A triangle surface on the lattice of steps.
struct Surface {
  std::vector<Point> points;                            // steps from the volume's low corner
  std::vector<std::uint8_t> planes;                     // per point: Plane bits
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from the air
  std::vector<std::uint16_t> materials;                 // per triangle
};

struct CellGroup;

/// Memory that one surface leaves to the next. For one thread.
struct Workspace {
  Workspace();
  ~Workspace();
  Surface surface;
  std::vector<std::unique_ptr<CellGroup>> groups;
};

/// Triangulates the crossings of `volume`: manifold dual contouring whose surface ends, on the
/// border planes of the box and at columns that are not meshed, in the two-dimensional dual
/// contour of that plane's lattice.
///
/// `units` is the number of steps per cell, at least 256. Every vertex stays one step inside its
/// cell, face or edge; no triangle is degenerate or doubled; each edge has two faces except on
/// those borders. Boxes that share a face agree on its curve to the step, so that in all of them
/// together an edge has one face only where both its ends carry `world_edge`. Where two columns
/// touch in an edge of the lattice between two that are not meshed, each has a vertex of its own
/// there, at the same place. Vertices come in a fixed order of the volume alone.
///
/// Errors: none. A volume without a crossing gives an empty surface.
/// Source: Schaefer, Ju, Warren 2007, Manifold Dual Contouring (sheets); Ju et al. 2002, Dual
/// Contouring of Hermite Data (QEF); DESIGN section 5 for borders, flips, nudges and diagonals.
///
/// `settle`, where given, may move the vertices of the cells before triangles are made, each inside
/// its own cell by one step at least; two of one cell must not meet. Those of a cell are neighbours
/// in the span.
Surface polygonize(const volume::Volume& volume, int units,
                   const std::function<void(std::span<Point>)>& settle = {});
/// The same in the memory of `workspace`, whose surface it becomes.
const Surface& polygonize(const volume::Volume& volume, int units, Workspace& workspace,
                          const std::function<void(std::span<Point>)>& settle = {});

}  // namespace hoodoo::surface
