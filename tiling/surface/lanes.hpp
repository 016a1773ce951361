#pragma once
#include <cstddef>
#include <cstdint>

namespace hoodoo::surface {

/// The planes of a few sheets, to be solved together: one sheet per lane.
struct SheetLanes {
  static constexpr std::size_t most = 16, most_planes = 12;
  alignas(64) float point[most_planes][3][most] = {};   // in the frame of the sheet's cell
  alignas(64) float normal[most_planes][3][most] = {};  // unit
  alignas(64) double count[most] = {};                  // of planes, at least 1
  // What solve finds.
  alignas(64) double mean[3][most] = {};         // of the points
  alignas(64) std::int32_t steps[3][most] = {};  // of the vertex, snapped
};
/// For the first n sheets the bits of mean_point, and snap of it plus minimise.
void solve(SheetLanes& sheets, std::size_t n, int units);

/// Quadrilaterals around lattice edges of one axis, to be cut together.
struct QuadLanes {
  static constexpr std::size_t most = 32;
  alignas(64) std::int32_t corner[4][3][most] = {};  // steps; counter-clockwise about the axis
  alignas(64) float wanted[3][most] = {};            // normal of the crossing
  alignas(64) float sign[most] = {};                 // +1: the edge's low end is solid, -1
  // What cut finds: the corner, 0 or 1, at which the diagonal begins.
  alignas(64) std::int32_t diagonal[most] = {};
};
/// The diagonal whose triangles both run counter-clockwise about the edge, which at least one does,
/// since the corners lie in successive quadrants around it. If both, the one whose triangles agree
/// better with the normal of the crossing.
void cut(QuadLanes& quads, std::size_t n, int axis);

}  // namespace hoodoo::surface
