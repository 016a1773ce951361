#include "engine/tree/region.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/hash.hpp"

namespace hoodoo::tree {
namespace {

/// Distance [m] to a boundary, positive inside, and its gradient [1].
struct Depth {
  double d;
  Vec3 gradient;
};

Depth depth_in(const Box& box, const Vec3& p) {
  Depth nearest{Box::infinity, {}};
  Vec3 out;  // how far p lies outside, axis by axis
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool low : {true, false}) {
      const double d = low ? p[axis] - box.min[axis] : box.max[axis] - p[axis];
      const double slope = low ? 1 : -1;
      if (d < 0) out[axis] = slope * d;
      if (d < nearest.d) {
        nearest = {d, {}};
        nearest.gradient[axis] = slope;
      }
    }
  }
  const double far = length(out);
  return far > 0 ? Depth{-far, out * (-1 / far)} : nearest;
}

Depth depth_in(const Region& region, const Vec3& p) {
  Depth d = depth_in(region.box, p);
  if (!region.polygon.empty()) {
    const EdgeDistance e = edge_distance(region.polygon, p.x, p.y);
    if (e.d < d.d) d = {e.d, {e.dx, e.dy, 0}};
  }
  return d;
}

/// The weight at depth d, and its slope.
std::pair<double, double> ramp(double d, double feather) {
  if (!(feather > 0)) return {d >= 0 ? 1 : 0, 0};
  const double u = std::clamp(2 * d / feather, -1.0, 1.0);
  return {(1 + u * (1.5 - 0.5 * u * u)) / 2, 1.5 * (1 - u * u) / feather};
}

/// Sample (i, j), held at the edge.
double sample(const Mask& mask, std::int64_t i, std::int64_t j) {
  const auto x = std::clamp<std::int64_t>(i, 0, mask.width - 1);
  const auto y = std::clamp<std::int64_t>(j, 0, mask.height - 1);
  return static_cast<double>(mask.weights[static_cast<std::size_t>(y * mask.width + x)]);
}

/// Place of x among the sample centres.
double grid_place(double x, double x0, double x1, int n) { return (x - x0) / (x1 - x0) * n - 0.5; }

Weight at(const Mask& mask, double x, double y) {
  if (x < mask.x0 || x > mask.x1 || y < mask.y0 || y > mask.y1) return {0, {}};
  const double u = grid_place(x, mask.x0, mask.x1, mask.width);
  const double v = grid_place(y, mask.y0, mask.y1, mask.height);
  const auto i = static_cast<std::int64_t>(std::floor(u));
  const auto j = static_cast<std::int64_t>(std::floor(v));
  const double s = u - std::floor(u), t = v - std::floor(v);
  const double a = sample(mask, i, j), b = sample(mask, i + 1, j);
  const double c = sample(mask, i, j + 1), d = sample(mask, i + 1, j + 1);
  const double south = a * (1 - s) + b * s, north = c * (1 - s) + d * s;
  const double per_x = mask.width / (mask.x1 - mask.x0);
  const double per_y = mask.height / (mask.y1 - mask.y0);
  return {south * (1 - t) + north * t,
          {((b - a) * (1 - t) + (d - c) * t) * per_x, (north - south) * per_y, 0}};
}

Interval over(const Mask& mask, const Box& box) {
  const Box rectangle{{mask.x0, mask.y0, -Box::infinity}, {mask.x1, mask.y1, Box::infinity}};
  if (!rectangle.overlaps(box)) return {0, 0};
  const auto cells = [](double low, double high, double from, double to, int n) {
    const double a = std::clamp(grid_place(low, from, to, n), -1.0, n + 0.0);
    const double b = std::clamp(grid_place(high, from, to, n), -1.0, n + 0.0);
    return std::pair(static_cast<std::int64_t>(std::floor(a)),
                     static_cast<std::int64_t>(std::floor(b)) + 1);
  };
  const auto columns = cells(box.min.x, box.max.x, mask.x0, mask.x1, mask.width);
  const auto rows = cells(box.min.y, box.max.y, mask.y0, mask.y1, mask.height);
  Interval found{1, 0};
  for (auto j = rows.first; j <= rows.second; ++j) {
    for (auto i = columns.first; i <= columns.second; ++i) {
      const double w = sample(mask, i, j);
      found = {std::min(found.low, w), std::max(found.high, w)};
    }
  }
  const bool leaves =
      box.min.x < mask.x0 || box.max.x > mask.x1 || box.min.y < mask.y0 || box.max.y > mask.y1;
  if (leaves) found.low = 0;
  return found;
}

nlohmann::json side(double v) { return std::isfinite(v) ? nlohmann::json(v) : nlohmann::json(); }

}  // namespace

Weight Region::weight(const Vec3& p) const {
  const Depth d = depth_in(*this, p);
  const auto [w, slope] = ramp(d.d, feather);
  const Weight edge{w, slope > 0 ? d.gradient * slope : Vec3{}};
  if (mask.width == 0) return edge;
  const Weight painted = at(mask, p.x, p.y);
  return {edge.w * painted.w, edge.gradient * painted.w + painted.gradient * edge.w};
}

Interval Region::weights(const Box& area) const {
  const Vec3 centre = (area.min + area.max) * 0.5;
  const double half = length(area.max - area.min) / 2 * (1 + 1e-9) + 1e-9;
  const double d = depth_in(*this, centre).d;
  const Interval edge{ramp(d - half, feather).first, ramp(d + half, feather).first};
  return mask.width == 0 ? edge : edge * over(mask, area);
}

Box Region::influence() const {
  Box all = box;
  if (!polygon.empty()) all = intersection(all, bounds(polygon));
  if (!all.empty()) all = all.grown(feather / 2);
  if (mask.width != 0) {
    all =
        intersection(all, {{mask.x0, mask.y0, -Box::infinity}, {mask.x1, mask.y1, Box::infinity}});
  }
  return all;
}

nlohmann::json to_json(const Region& region) {
  nlohmann::json json{{"feather", region.feather}, {"polygon", region.polygon}};
  for (int axis = 0; axis < 3; ++axis) {
    json["box"]["min"].push_back(side(region.box.min[axis]));
    json["box"]["max"].push_back(side(region.box.max[axis]));
  }
  if (region.mask.width != 0) {
    const Mask& m = region.mask;
    json["mask"] = {{"box", {m.x0, m.y0, m.x1, m.y1}},
                    {"size", {m.width, m.height}},
                    {"sha256", sha256(std::as_bytes(std::span(m.weights))).hex()}};
  }
  return json;
}

}  // namespace hoodoo::tree
