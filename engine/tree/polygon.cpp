#include "engine/tree/polygon.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::tree {
namespace {

/// Twice the area, positive where the corners run counter-clockwise.
double winding(const Polygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    sum += polygon[j][0] * polygon[i][1] - polygon[i][0] * polygon[j][1];
  }
  return sum;
}

}  // namespace

EdgeDistance edge_distance(const Polygon& polygon, double x, double y) {
  double nearest = std::numeric_limits<double>::infinity();
  double dx = 0, dy = 0;  // from the nearest point of the edge to (x, y)
  double ux = 0, uy = 0;  // along the nearest side
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto &a = polygon[j], &b = polygon[i];
    const double sx = b[0] - a[0], sy = b[1] - a[1], px = x - a[0], py = y - a[1];
    const double l2 = sx * sx + sy * sy;
    const double t = l2 > 0 ? std::clamp((px * sx + py * sy) / l2, 0.0, 1.0) : 0;
    const double ex = px - t * sx, ey = py - t * sy, d2 = ex * ex + ey * ey;
    if (d2 < nearest) {
      nearest = d2;
      dx = ex;
      dy = ey;
      ux = sx;
      uy = sy;
    }
    if ((a[1] > y) != (b[1] > y) && x < a[0] + sx * ((y - a[1]) / sy)) inside = !inside;
  }
  const double d = std::sqrt(nearest), sign = inside ? 1 : -1;
  if (d > 0) return {sign * d, sign * dx / d, sign * dy / d};
  // On the edge itself: the inward normal of its side.
  const double l = std::sqrt(ux * ux + uy * uy), turn = winding(polygon) > 0 ? 1 : -1;
  return l > 0 ? EdgeDistance{0, -turn * uy / l, turn * ux / l} : EdgeDistance{0, 0, 0};
}

Interval edge_distance(const Polygon& polygon, const Box& box) {
  const double x = (box.min.x + box.max.x) / 2, y = (box.min.y + box.max.y) / 2;
  const double wx = box.max.x - box.min.x, wy = box.max.y - box.min.y;
  const double half = std::sqrt(wx * wx + wy * wy) / 2 * (1 + 1e-9);
  const double d = edge_distance(polygon, x, y).d;
  return {d - half, d + half};
}

Box bounds(const Polygon& polygon) {
  Box box = Box::everywhere();
  if (polygon.empty()) return Box();
  box.min.x = box.max.x = polygon[0][0];
  box.min.y = box.max.y = polygon[0][1];
  for (const auto& corner : polygon) {
    box.min.x = std::min(box.min.x, corner[0]);
    box.max.x = std::max(box.max.x, corner[0]);
    box.min.y = std::min(box.min.y, corner[1]);
    box.max.y = std::max(box.max.y, corner[1]);
  }
  return box;
}

}  // namespace hoodoo::tree
