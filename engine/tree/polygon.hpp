#pragma once
#include <array>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"

namespace hoodoo::tree {

/// Signed distance [m] to a polygon's edge, positive inside, and its gradient [1].
struct EdgeDistance {
  double d, dx, dy;
};

/// Corners [m], closed from the last to the first; even-odd rule.
using Polygon = std::vector<std::array<double, 2>>;

/// Exact; in double, the same bits for the same (x, y). Polygon of three corners at least.
EdgeDistance edge_distance(const Polygon& polygon, double x, double y);

/// Contains edge_distance().d over the box (x and y).
Interval edge_distance(const Polygon& polygon, const Box& box);

/// Corners' box; z is unbounded.
Box bounds(const Polygon& polygon);

}  // namespace hoodoo::tree
