#include "tiling/lod/buckets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/box.hpp"

namespace hoodoo::lod {

double distance2(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto from = [&](const Vec3& q) { return dot(p - q, p - q); };
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return dot(ap, ap);
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return dot(bp, bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return from(a + ab * (d1 / (d1 - d3)));
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return dot(cp, cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return from(a + ac * (d2 / (d2 - d6)));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return from(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
  }
  const Vec3 normal = cross(ab, ac);
  const double square = dot(normal, normal), offset = dot(normal, ap);
  // A triangle without area can come here by rounding; its corners span it.
  if (!(square > 0)) return std::min(std::min(from(a), from(b)), from(c));
  return offset * offset / square;
}

Buckets::Buckets(std::span<const Vec3> points, std::span<const Triangle> triangles, double side) {
  if (triangles.empty()) return;
  corners_.reserve(triangles.size());
  Box box;
  for (const auto& t : triangles) {
    corners_.push_back({points[t[0]], points[t[1]], points[t[2]]});
    for (const auto& corner : corners_.back()) box.add(corner);
  }
  low_ = box.min;
  high_ = box.max;
  choose_size(side);
  std::vector<Cell> cells;
  cells.reserve(points.size());
  for (const auto& p : points) cells.push_back(cell(p));
  // The buckets of each triangle, one after the other, counted on the way.
  std::vector<std::uint32_t> buckets, ends;
  buckets.reserve(4 * triangles.size());
  ends.reserve(triangles.size());
  boxes_.reserve(triangles.size());
  first_.assign(index({size_[0] - 1, size_[1] - 1, size_[2] - 1}) + 2, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [i, j, k] = triangles[t];
    for_each_cell(corners_[t], around(cells[i], cells[j], cells[k]), [&](const Cell& c) {
      buckets.push_back(static_cast<std::uint32_t>(index(c)));
      ++first_[buckets.back() + 1];
    });
    ends.push_back(static_cast<std::uint32_t>(buckets.size()));
    boxes_.push_back(box_of(corners_[t]));
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  members_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0, m = 0; t < ends.size(); ++t) {
    for (; m < ends[t]; ++m) members_[next[buckets[m]]++] = t;
  }
}

void Buckets::choose_size(double side) {
  const double most = 4 * static_cast<double>(corners_.size()) + 4096;
  const Vec3 extent = high_ - low_;
  const auto along = [&](int axis) { return std::floor(extent[axis] / side_) + 1; };
  side_ = side;
  while (along(0) * along(1) * along(2) > most) side_ *= 1.25;
  per_side_ = 1 / side_;
  for (int axis = 0; axis < 3; ++axis) {
    size_[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(along(axis));
  }
  // Places and boxes are rounded, and subtracted.
  slack_ = static_cast<float>(std::max(std::max(extent.x, extent.y), extent.z)) *
           (4 * std::numeric_limits<float>::epsilon());
}

Buckets::Cell Buckets::cell(const Vec3& p) const {
  Cell result;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double at = (p[axis] - low_[axis]) * per_side_;  // the conversion rounds down
    result[a] = static_cast<std::int32_t>(std::clamp(at, 0.0, static_cast<double>(size_[a] - 1)));
  }
  return result;
}

Buckets::Range Buckets::around(const Cell& i, const Cell& j, const Cell& k) {
  Range range{i, i};
  for (std::size_t a = 0; a < 3; ++a) {
    range.low[a] = std::min(std::min(i[a], j[a]), k[a]);
    range.high[a] = std::max(std::max(i[a], j[a]), k[a]);
  }
  return range;
}

/// Relative to the lowest corner of all, so that small numbers are rounded.
Buckets::Bounds Buckets::box_of(const Corners& triangle) const {
  const auto& [a, b, c] = triangle;
  Bounds bounds{};
  for (int axis = 0; axis < 3; ++axis) {
    const double least = std::min(std::min(a[axis], b[axis]), c[axis]) - low_[axis];
    const double most = std::max(std::max(a[axis], b[axis]), c[axis]) - low_[axis];
    const auto at = static_cast<std::size_t>(axis);
    bounds.low[at] = static_cast<float>(least) - slack_;
    bounds.high[at] = static_cast<float>(most) + slack_;
  }
  return bounds;
}

template <class Visit>
void Buckets::for_each_cell(const Corners& triangle, const Range& range, Visit visit) const {
  const Cell &low = range.low, &high = range.high;
  const auto along = [&](std::size_t a) { return std::int64_t{high[a] - low[a] + 1}; };
  if (along(0) * along(1) * along(2) > 12) {
    const Vec3 normal = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    if (dot(normal, normal) > 0) {
      for_each_cell_of_plane(triangle, normal, low, high, visit);
      return;
    }
  }
  for (std::int32_t z = low[2]; z <= high[2]; ++z) {
    for (std::int32_t y = low[1]; y <= high[1]; ++y) {
      for (std::int32_t x = low[0]; x <= high[0]; ++x) visit(Cell{x, y, z});
    }
  }
}

/// The cells of [low, high] that the triangle's plane passes through, column by column along the
/// axis nearest its normal, where it passes through three at most. Columns beside the triangle's
/// projection are left out.
template <class Visit>
void Buckets::for_each_cell_of_plane(const Corners& triangle, const Vec3& normal, const Cell& low,
                                     const Cell& high, Visit visit) const {
  int d = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(normal[axis]) > std::abs(normal[d])) d = axis;
  }
  const int u = (d + 1) % 3, v = (d + 2) % 3;
  const auto du = static_cast<std::size_t>(u), dv = static_cast<std::size_t>(v),
             dd = static_cast<std::size_t>(d);
  const double half = 0.5 * side_ * (1 + 1e-9);
  const double facing = normal[d] > 0 ? 1 : -1;
  const auto outside = [&](double cu, double cv) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& a = triangle[i];
      const Vec3 edge = triangle[(i + 1) % 3] - a;
      const double side = facing * (edge[u] * (cv - a[v]) - edge[v] * (cu - a[u]));
      if (side + half * (std::abs(edge[u]) + std::abs(edge[v])) < 0) return true;
    }
    return false;
  };
  const double spread = half * (std::abs(normal[u]) + std::abs(normal[v])) / std::abs(normal[d]);
  for (std::int32_t i = low[du]; i <= high[du]; ++i) {
    const double cu = low_[u] + (i + 0.5) * side_;
    for (std::int32_t j = low[dv]; j <= high[dv]; ++j) {
      const double cv = low_[v] + (j + 0.5) * side_;
      if (outside(cu, cv)) continue;
      const Vec3& a = triangle[0];
      const double middle =
          a[d] - (normal[u] * (cu - a[u]) + normal[v] * (cv - a[v])) / normal[d] - low_[d];
      const auto clamped = [&](double at) {
        return static_cast<std::int32_t>(std::clamp(std::floor(at * per_side_),
                                                    static_cast<double>(low[dd]),
                                                    static_cast<double>(high[dd])));
      };
      Cell c;
      c[du] = i;
      c[dv] = j;
      const std::int32_t last = clamped(middle + spread + 1e-9 * side_);
      for (c[dd] = clamped(middle - spread - 1e-9 * side_); c[dd] <= last; ++c[dd]) visit(c);
    }
  }
}

double Buckets::beyond(const Vec3& p, double bound2, std::uint32_t& hint) const {
  const auto to = [&](std::uint32_t t) {
    return distance2(p, corners_[t][0], corners_[t][1], corners_[t][2]);
  };
  if (hint >= corners_.size()) hint = 0;
  double best = to(hint);
  if (best <= bound2) return bound2;
  // Most points have a triangle within the bound in their own bucket: others need no distance.
  const auto row = index(cell(p));
  const auto from = relative(p);
  const float bound = static_cast<float>(bound2) * rounding;
  const auto within = [&](std::uint32_t t) {
    if (box_distance2(from, t) > bound || to(t) > bound2) return false;
    hint = t;
    return true;
  };
  if (any_in_row(row, 1, within)) return bound2;
  const auto nearer = [&](std::uint32_t t) {
    if (box_distance2(from, t) > static_cast<float>(best) * rounding) return false;
    const double d = to(t);
    if (d < best) {
      best = d;
      hint = t;
    }
    return best <= bound2;
  };
  any_in_row(row, 1, nearer);
  // Whatever lies within the reach has been seen, so a best within it is the nearest.
  for (double reach = std::max(std::sqrt(bound2), 0.25 * side_);; reach *= 2) {
    if (any_near(p, std::min(reach, std::sqrt(best)), nearer)) return bound2;
    if (best <= reach * reach) return best;
  }
}

bool Buckets::faces(const Vec3& p, double reach, const Vec3& normal, std::uint32_t& hint) const {
  const auto from = relative(p);
  const float bound = static_cast<float>(reach * reach) * rounding;
  const auto serves = [&](std::uint32_t t) {
    if (box_distance2(from, t) > bound) return false;
    const auto& [a, b, c] = corners_[t];
    if (!(dot(cross(b - a, c - a), normal) > 0 && distance2(p, a, b, c) <= reach * reach)) {
      return false;
    }
    hint = t;
    return true;
  };
  if (hint >= corners_.size()) hint = 0;
  return serves(hint) || any_in_row(index(cell(p)), 1, serves) || any_near(p, reach, serves);
}

}  // namespace hoodoo::lod
