#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/vector.hpp"
#include "tiling/lod/half_edges.hpp"

namespace hoodoo::lod {

/// Squared distance of `p` from the triangle (a, b, c); from the segment (a, b) where b = c.
/// Source: Ericson 2005, Real-Time Collision Detection, section 5.1.5.
double distance2(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Triangles sorted into cubic buckets, to be asked how far points are from them.
///
/// A question is cheap when its answer is "no farther than so much": the first triangle near
/// enough ends it. So the largest distance of many points is found by asking each whether it is
/// farther than the largest so far. Safe to ask from any number of threads.
class Buckets {
 public:
  /// Buckets of about `side`, larger where that would make many more buckets than triangles.
  Buckets(std::span<const Vec3> points, std::span<const Triangle> triangles, double side);

  bool empty() const { return corners_.empty(); }

  /// The squared distance of `p` to the nearest triangle where that exceeds `bound2`, else
  /// `bound2`. `hint` is a triangle to try first, and becomes the one that answered.
  /// There must be triangles.
  double beyond(const Vec3& p, double bound2, std::uint32_t& hint) const;

  /// Some triangle within `reach` of `p` faces the same way as `normal`; `hint` as in `beyond`.
  bool faces(const Vec3& p, double reach, const Vec3& normal, std::uint32_t& hint) const;

  /// Calls visit(triangle) for triangles within `reach` of `p`, some more than once.
  template <class Visit>
  void for_each_near(const Vec3& p, double reach, Visit visit) const {
    const auto from = relative(p);
    const float bound = static_cast<float>(reach * reach) * rounding;
    any_near(p, reach, [&](std::uint32_t t) {
      if (box_distance2(from, t) > bound) return false;
      const auto& [a, b, c] = corners_[t];
      if (distance2(p, a, b, c) <= reach * reach) visit(t);
      return false;
    });
  }

 private:
  static constexpr float rounding = 1 + 1e-5F;
  using Cell = std::array<std::int32_t, 3>;
  using Corners = std::array<Vec3, 3>;

  Cell cell(const Vec3& p) const;
  std::size_t index(const Cell& c) const {
    return (static_cast<std::size_t>(c[2]) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(c[1])) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(c[0]);
  }
  void choose_size(double side);
  struct Range {
    Cell low, high;
  };
  static Range around(const Cell& i, const Cell& j, const Cell& k);
  /// A triangle's box in single precision, wide enough to hold it all the same.
  struct Bounds {
    std::array<float, 3> low, high;
  };
  Bounds box_of(const Corners& triangle) const;
  std::array<float, 3> relative(const Vec3& p) const {
    return {static_cast<float>(p.x - low_.x), static_cast<float>(p.y - low_.y),
            static_cast<float>(p.z - low_.z)};
  }
  /// The squared distance of a relative place from the box of a triangle, which is a lower bound
  /// of that to the triangle but for a rounding by less than `rounding`.
  float box_distance2(const std::array<float, 3>& p, std::uint32_t triangle) const {
    const auto& [low, high] = boxes_[triangle];
    float sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const float out = std::max(std::max(low[a] - p[a], p[a] - high[a]), 0.0F);
      sum += out * out;
    }
    return sum;
  }
  template <class Visit>
  void for_each_cell(const Corners& triangle, const Range& range, Visit visit) const;
  template <class Visit>
  void for_each_cell_of_plane(const Corners& triangle, const Vec3& normal, const Cell& low,
                              const Cell& high, Visit visit) const;
  template <class Visit>
  bool any_in_row(std::size_t row, std::size_t width, Visit visit) const {
    for (auto m = first_[row]; m < first_[row + width]; ++m) {
      if (visit(members_[m])) return true;
    }
    return false;
  }
  /// Visits the triangles of every bucket that touches the cube of half side `reach` around `p`,
  /// until a visit gives true.
  template <class Visit>
  bool any_near(const Vec3& p, double reach, Visit visit) const {
    const Vec3 by{reach, reach, reach};
    const Cell low = cell(p - by), high = cell(p + by);
    const auto width = static_cast<std::size_t>(high[0] - low[0]) + 1;
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) {
        if (any_in_row(index({low[0], y, z}), width, visit)) return true;
      }
    }
    return false;
  }

  std::vector<Corners> corners_;
  std::vector<Bounds> boxes_;
  Vec3 low_, high_;
  double side_ = 1, per_side_ = 1;
  float slack_ = 0;  // boxes are so much wider
  Cell size_{1, 1, 1};
  std::vector<std::uint32_t> first_;    // per bucket, into members_
  std::vector<std::uint32_t> members_;  // triangles
};

}  // namespace hoodoo::lod
