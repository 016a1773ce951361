#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/base/vector.hpp"
#include "tiling/lod/buckets.hpp"

namespace hoodoo::lod {

/// Calls visit(point) for samples of a triangle: rows along its longest edge, at most `spacing`
/// apart, points at most as far apart in each. Corners are left out. A segment is a triangle (a, b,
/// b).
template <class Visit>
void for_each_sample(Vec3 a, Vec3 b, Vec3 c, double spacing, Visit visit) {
  const auto turn = [&] {
    const Vec3 first = a;
    a = b;
    b = c;
    c = first;
  };
  const double ab = dot(b - a, b - a), bc = dot(c - b, c - b), ca = dot(a - c, a - c);
  if (bc > ab && bc >= ca) {
    turn();
  } else if (ca > ab) {
    turn();
    turn();
  }
  const double base = length(b - a);
  const auto parts_of = [&](double extent) {
    return std::max(1, static_cast<int>(std::ceil(extent / spacing)));
  };
  const int rows = parts_of(length(cross(b - a, c - a)) / std::max(base, spacing));
  for (int row = 0; row < rows; ++row) {
    const double up = static_cast<double>(row) / rows;
    const Vec3 from = a + (c - a) * up, along = (b - a) * (1 - up);
    const int parts = parts_of(base * (1 - up));
    for (int i = row == 0 ? 1 : 0; i < parts + (row == 0 ? 0 : 1); ++i) {
      visit(from + along * (static_cast<double>(i) / parts));
    }
  }
}

/// Largest distance of many points from one surface, at least `floor`. On level ground nearly every
/// distance is rounding: asking for the exact largest of those would visit every triangle around
/// every point.
class Farthest {
 public:
  Farthest(double limit, double floor) : limit2_(limit * limit), worst2_(floor * floor) {}

  /// False when `p` lies beyond the limit; it is then not counted.
  bool look(const Vec3& p, const Buckets& other) {
    last2_ = other.beyond(p, worst2_, hint_);
    if (last2_ > limit2_) return false;
    worst2_ = last2_;
    return true;
  }
  double distance() const { return std::sqrt(worst2_); }
  /// The last point's squared distance, or the largest so far where it is not farther.
  double last2() const { return last2_; }
  /// The triangle that answered for the last point: not farther than the largest distance so far.
  std::uint32_t nearest() const { return hint_; }

 private:
  double limit2_, worst2_, last2_ = 0;
  std::uint32_t hint_ = 0;
};

}  // namespace hoodoo::lod
