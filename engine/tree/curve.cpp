#include "engine/tree/curve.hpp"

#include <algorithm>
#include <cmath>

namespace hoodoo::tree {

std::vector<Cubic> catmull_rom(const std::vector<Point>& points, bool closed) {
  const std::size_t n = points.size(), spans = closed ? n : n - 1;
  const auto at = [&](std::size_t i) { return points[i % n].value; };
  std::vector<Cubic> curve;
  curve.reserve(spans);
  for (std::size_t i = 0; i < spans; ++i) {
    const Vec3 p = at(i), q = at(i + 1);
    const Vec3 before = closed || i > 0 ? at(i + n - 1) : p * 2 - q;
    const Vec3 after = closed || i + 2 < n ? at(i + 2) : q * 2 - p;
    curve.push_back({p, p + (q - before) * (1.0 / 6), q - (after - p) * (1.0 / 6), q});
  }
  return curve;
}

std::vector<Cubic> bezier(const std::vector<Point>& points) {
  std::vector<Cubic> curve;
  for (std::size_t i = 0; i + 3 < points.size(); i += 3) {
    curve.push_back(
        {points[i].value, points[i + 1].value, points[i + 2].value, points[i + 3].value});
  }
  return curve;
}

Box hull(const std::vector<Cubic>& curve) {
  Box box;
  for (const Cubic& c : curve) {
    for (const Vec3& p : {c.a, c.b, c.c, c.d}) box.add(p);
  }
  return box;
}

std::vector<Vec3> flattened(const std::vector<Cubic>& curve, double tolerance) {
  std::vector<Vec3> chain{curve.front().a};
  for (const Cubic& c : curve) {
    // A chord over 1/n of the parameter leaves the curve by |B''| / (8 n^2) at most.
    const double bend = 6 * std::max(length(c.a - c.b * 2 + c.c), length(c.b - c.c * 2 + c.d)) / 8;
    const double wanted = std::sqrt(bend / std::max(tolerance, 1e-12));
    const int lines = static_cast<int>(std::clamp(std::ceil(wanted), 1.0, 64.0));
    for (int k = 1; k < lines; ++k) {
      const double t = static_cast<double>(k) / lines, s = 1 - t;
      chain.push_back(c.a * (s * s * s) + c.b * (3 * s * s * t) + c.c * (3 * s * t * t) +
                      c.d * (t * t * t));
    }
    chain.push_back(c.d);
  }
  return chain;
}

bool keep_near(Polyline::Shape<float>& shape, double reach, const Block& block) {
  const Box here{block.box.min - block.origin, block.box.max - block.origin};
  std::erase_if(shape.segments, [&](const Segment::Shape<float>& s) {
    const Vec3 from{static_cast<double>(s.x), static_cast<double>(s.y), static_cast<double>(s.z)};
    const Vec3 along{static_cast<double>(s.ux), static_cast<double>(s.uy),
                     static_cast<double>(s.uz)};
    Box box{from, from};
    box.add(from + along);
    const double slack = 1e-5 * (reach + length(from) + length(along));
    return !box.grown(reach + slack).overlaps(here);
  });
  return !shape.segments.empty();
}

}  // namespace hoodoo::tree
