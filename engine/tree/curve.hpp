#pragma once
#include <vector>

#include "engine/tree/nodes/polyline.hpp"

namespace hoodoo::tree {

/// A cubic by its Bezier control points [m].
struct Cubic {
  Vec3 a, b, c, d;
};

/// Through the points, with the tangent (p_{i+1} - p_{i-1}) / 2 at each; an open curve's ends
/// are continued by reflection. Source: Catmull, Rom 1974, A class of local interpolating splines.
std::vector<Cubic> catmull_rom(const std::vector<Point>& points, bool closed);

/// Points 0-3, 3-6, 6-9 ... control one cubic each.
std::vector<Cubic> bezier(const std::vector<Point>& points);

/// Where the curve lies at most: a cubic stays within its control points.
Box hull(const std::vector<Cubic>& curve);

/// A chain no farther than `tolerance` [m] from the curve, but of at most 64 lines per cubic. Cut
/// evenly in the parameter, as many times as the second derivative asks for.
std::vector<Vec3> flattened(const std::vector<Cubic>& curve, double tolerance);

/// A flattened curve as a polyline's shape.
template <class S>
Polyline::Shape<S> curve_shape(const std::vector<Cubic>& curve, double tolerance, double radius,
                               const Vec3& origin) {
  const std::vector<Vec3> chain = flattened(curve, tolerance);
  Polyline::Shape<S> shape;
  shape.segments.reserve(chain.size());
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    shape.segments.push_back(
        Segment::shape_between<S>(chain[i] - origin, chain[i + 1] - origin, radius));
  }
  return shape;
}

/// Drops from `shape` the segments farther than `reach` [m] from the block; false when none is
/// left.
bool keep_near(Polyline::Shape<float>& shape, double reach, const Block& block);

}  // namespace hoodoo::tree
