#pragma once
#include <algorithm>
#include <cstdint>

#include "engine/base/box.hpp"

namespace hoodoo::tree {

/// A Z-order curve (Morton 1966) through a box, in steps of the 2^21st part of its longest side.
class MortonCurve {
 public:
  explicit MortonCurve(const Box& box) : low_(box.min) {
    const Vec3 size = box.max - box.min;
    scale_ = 2097151 / std::max({size.x, size.y, size.z, 1e-9});
  }

  /// Where on the curve a point of the box is.
  std::uint64_t at(const Vec3& point) const {
    const Vec3 p = (point - low_) * scale_;
    const auto bits = [](double v) { return spread(static_cast<std::uint64_t>(v)); };
    return bits(p.x) | bits(p.y) << 1 | bits(p.z) << 2;
  }

 private:
  /// Every third bit of 21.
  static std::uint64_t spread(std::uint64_t v) {
    v = (v | v << 32) & 0x001f00000000ffffULL;
    v = (v | v << 16) & 0x001f0000ff0000ffULL;
    v = (v | v << 8) & 0x100f00f00f00f00fULL;
    v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2) & 0x1249249249249249ULL;
  }

  Vec3 low_;
  double scale_;
};

}  // namespace hoodoo::tree
