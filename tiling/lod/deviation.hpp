#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "engine/base/vector.hpp"
#include "tiling/lod/buckets.hpp"

namespace hoodoo::lod {

/// Calls visit(point) for samples of a triangle on a lattice whose edges are at most `spacing`
/// long. Corners are left out; a segment (a, b, b) is sampled along its length.
template <class Visit>
void for_each_sample(const Vec3& a, const Vec3& b, const Vec3& c, double spacing, Visit visit) {
  const double longest =
      std::sqrt(std::max({dot(b - a, b - a), dot(c - a, c - a), dot(c - b, c - b)}));
  const int parts = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
  const Vec3 u = (b - a) * (1.0 / parts), v = (c - a) * (1.0 / parts);
  for (int i = 0; i <= parts; ++i) {
    for (int j = 0; j <= parts - i; ++j) {
      if (i == parts || j == parts || i + j == 0) continue;
      visit(a + u * i + v * j);
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
    const double d = other.beyond(p, worst2_, hint_);
    if (d > limit2_) return false;
    worst2_ = d;
    return true;
  }
  double distance() const { return std::sqrt(worst2_); }

 private:
  double limit2_, worst2_;
  std::uint32_t hint_ = 0;
};

}  // namespace hoodoo::lod
