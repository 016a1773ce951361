#pragma once
#include <algorithm>
#include <limits>

#include "engine/base/vector.hpp"

namespace hoodoo {

/// A closed axis-aligned box [m]. Empty when a minimum exceeds its maximum.
struct Box {
  Vec3 min{infinity, infinity, infinity};
  Vec3 max{-infinity, -infinity, -infinity};

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static Box everywhere() {
    return {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
  }

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  bool contains(const Vec3& p) const {
    return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z &&
           p.z <= max.z;
  }
  bool contains(const Box& b) const { return b.empty() || (contains(b.min) && contains(b.max)); }
  bool overlaps(const Box& b) const {
    return min.x <= b.max.x && max.x >= b.min.x && min.y <= b.max.y && max.y >= b.min.y &&
           min.z <= b.max.z && max.z >= b.min.z;
  }
  Box grown(double by) const {
    return {{min.x - by, min.y - by, min.z - by}, {max.x + by, max.y + by, max.z + by}};
  }
  void add(const Vec3& p) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void add(const Box& b) {
    if (b.empty()) return;
    add(b.min);
    add(b.max);
  }
  friend bool operator==(const Box&, const Box&) = default;
};

inline Box intersection(const Box& a, const Box& b) {
  return {{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y), std::max(a.min.z, b.min.z)},
          {std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y), std::min(a.max.z, b.max.z)}};
}

}  // namespace hoodoo
