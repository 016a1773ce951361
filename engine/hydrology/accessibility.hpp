#pragma once
#include <vector>

#include "engine/hydrology/grid.hpp"

namespace hoodoo::hydrology {

/// Radius [m] of the largest ball that touches the height field at a cell's centre from above and
/// holds no other: the least |q - p|^2 / (2 n.(q - p)) of all q on the side of the normal n; at
/// most `most`. Cells without an elevation hinder no ball; NaN where there is none.
/// Source: Miller 1994, Efficient algorithms for local and global accessibility shading (tangent
/// sphere accessibility).
double tangent_ball(const Grid& grid, std::int32_t i, std::int32_t j, double most);

/// tangent_ball / most of every cell of these rows: in [0, 1], 1 where the ground is open.
std::vector<float> accessibility(const Grid& grid, double most, Rows rows);

/// So many rows above and below decide it.
std::int32_t accessibility_reach(const Grid& grid, double most);

}  // namespace hoodoo::hydrology
