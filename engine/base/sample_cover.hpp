#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "engine/base/sample_cells.hpp"
#include "engine/base/vector.hpp"

/// What room samples leave in boxes, for sampler.hpp.
namespace hoodoo::sampling {

struct Cube {  // a square in the plane, a square column in a shell
  Vec3 low, high;
  Vec3 middle() const { return (low + high) * 0.5; }
};

inline double squared_farthest(const Cube& b, const Vec3& p) {
  const auto far = [](double low, double high, double v) {
    return squared(std::max(high - v, v - low));
  };
  return far(b.low.x, b.high.x, p.x) + far(b.low.y, b.high.y, p.y) + far(b.low.z, b.high.z, p.z);
}
inline double squared_nearest(const Cube& b, const Vec3& p) {
  const auto near = [](double low, double high, double v) {
    return squared(std::max(std::max(low - v, v - high), 0.0));
  };
  return near(b.low.x, b.high.x, p.x) + near(b.low.y, b.high.y, p.y) + near(b.low.z, b.high.z, p.z);
}

/// The samples that can matter to a cell. Boxes in it are compared with many at once, in single
/// precision from the cell on: each sample is taken for smaller than it is by more than the
/// rounding. Points are compared exactly.
class Nearby {
 public:
  /// Forgets all; from now on of a cell that has this corner.
  void clear(const Vec3& corner) {
    samples_.clear();
    for (auto* list : {&x_, &y_, &z_, &radius_}) list->clear();
    corner_ = corner;
  }
  void add(const Sample& s) {
    const auto n = samples_.size();
    samples_.push_back(s);
    if (n % lanes == 0) {  // those without a sample are too far to matter
      for (auto* list : {&x_, &y_, &z_, &radius_}) list->resize(n + lanes, 1e18F);
      std::fill(radius_.end() - lanes, radius_.end(), 0.0F);
      left_.resize(n / lanes + 1);
    }
    const Vec3 p = s.center - corner_;
    x_[n] = static_cast<float>(p.x), y_[n] = static_cast<float>(p.y);
    z_[n] = static_cast<float>(p.z), radius_[n] = static_cast<float>(s.radius);
  }

  /// Whether a sample lies too near to a sample of that radius there.
  bool rule_out(const Vec3& p, double radius) const {
    return std::ranges::any_of(samples_, [&](const Sample& s) { return conflict(s, p, radius); });
  }

  std::size_t size() const { return samples_.size(); }

  /// The height, this share of the way up through all those from `low` to `high` that they leave to
  /// samples of that radius at x and y of `p`; NaN where they leave none.
  double height_left(const Vec3& p, double low, double high, double radius, double share) const {
    constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
    taken_.clear();
    for (const auto& s : samples_) {
      const double left =
          squared(s.radius + radius) - squared(s.center.x - p.x) - squared(s.center.y - p.y);
      if (left <= 0) continue;
      const double half = std::sqrt(left), from = s.center.z - half, to = s.center.z + half;
      if (from <= low && to >= high) return nothing;
      if (from < high && to > low) taken_.push_back({from, to});
    }
    if (taken_.empty()) return low + (high - low) * share;
    std::ranges::sort(taken_);
    taken_.push_back({high, high});
    double room = 0, below = low;
    for (const auto& [from, to] : taken_) {
      room += std::max(from - below, 0.0);
      below = std::max(below, to);
    }
    if (room <= 0) return nothing;
    double up = share * room;
    below = low;
    for (const auto& [from, to] : taken_) {
      if (below + up <= from) break;
      up -= std::max(from - below, 0.0);
      below = std::max(below, to);
    }
    return std::min(below + up, high);
  }

  /// Whether one of them, at least of those after the first `known`, leaves no room in the whole
  /// box to radii from that on.
  bool cover(const Cube& box, double radius, std::size_t known = 0) const {
    if (known == samples_.size()) return false;
    const Extent of(box, corner_);
    const auto r = static_cast<float>(radius);
    for (std::size_t first = known / lanes * lanes; first < x_.size(); first += lanes) {
      unsigned found = 0;
      for (std::size_t n = first; n < first + lanes; ++n) {
        const float dx = std::abs(x_[n] - of.x) + of.half_x,
                    dy = std::abs(y_[n] - of.y) + of.half_y,
                    dz = std::abs(z_[n] - of.z) + of.half_z, reach = (radius_[n] + r) * shrunk;
        found |= static_cast<unsigned>(dx * dx + dy * dy + dz * dz < reach * reach);
      }
      if (found != 0) return true;
    }
    return false;
  }

  /// Asks all samples about the four halves of a column at once, for radii from that on: what
  /// `narrow` is to know of each.
  void halve(const Cube& box, double radius) const {
    const Extent of(box, corner_);
    const auto least = static_cast<float>(radius);
    const float half_x = of.half_x / 2, half_y = of.half_y / 2;
    const float x0 = of.x - half_x, x1 = of.x + half_x, y0 = of.y - half_y, y1 = of.y + half_y;
    covered_whole_ = {};
    for (std::size_t first = 0; first < x_.size(); first += lanes) {
      const float *x = &x_[first], *y = &y_[first], *z = &z_[first], *r = &radius_[first];
      Left left{};  // apart from the list, so that the loop is done at once
      std::array<unsigned, 4> whole{};
      for (std::size_t n = 0; n < lanes; ++n) {
        const float reach = (r[n] + least) * shrunk, all = reach * reach;
        const float dz = std::abs(z[n] - of.z) + of.half_z, height = dz * dz;
        const float dx0 = std::abs(x[n] - x0) + half_x, dx1 = std::abs(x[n] - x1) + half_x;
        const float dy0 = std::abs(y[n] - y0) + half_y, dy1 = std::abs(y[n] - y1) + half_y;
        left[0][n] = all - dx0 * dx0 - dy0 * dy0;
        left[1][n] = all - dx1 * dx1 - dy0 * dy0;
        left[2][n] = all - dx0 * dx0 - dy1 * dy1;
        left[3][n] = all - dx1 * dx1 - dy1 * dy1;
        whole[0] |= static_cast<unsigned>(height < left[0][n]);
        whole[1] |= static_cast<unsigned>(height < left[1][n]);
        whole[2] |= static_cast<unsigned>(height < left[2][n]);
        whole[3] |= static_cast<unsigned>(height < left[3][n]);
      }
      for (std::size_t half = 0; half < 4; ++half) covered_whole_[half] |= whole[half];
      left_[first / lanes] = left;
    }
  }

  /// Of the half with that number (x fastest) of the column that was halved, takes from its top and
  /// bottom what samples leave no room in, and before what `bound` says of them. False: nothing is
  /// left.
  template <class Bound>
  bool narrow(Cube& box, std::size_t half, const Bound& bound) const {
    if (covered_whole_[half] != 0 || !bound(box)) return false;
    auto low = static_cast<float>(box.low.z - corner_.z);
    auto high = static_cast<float>(box.high.z - corner_.z);
    const float bottom = low, top = high;
    covered_.clear();
    for (std::size_t n = 0; n < samples_.size(); ++n) {
      const float left = left_[n / lanes][half][n % lanes];
      if (left <= 0) continue;
      const float reach = std::sqrt(left);
      covered_.push_back({z_[n] - reach, z_[n] + reach});
    }
    for (bool moved = true; moved && low <= high;) {
      moved = false;
      for (const auto& [from, to] : covered_) {
        if (from <= low && to > low) low = to, moved = true;
        if (to >= high && from < high) high = from, moved = true;
      }
    }
    if (low > high) return false;
    if (low > bottom) box.low.z = corner_.z + static_cast<double>(low);
    if (high < top) box.high.z = corner_.z + static_cast<double>(high);
    return true;
  }

 private:
  static constexpr std::size_t lanes = 8;
  static constexpr float shrunk = 1 - 1e-5F;
  /// Of each half and sample, the square of how far above and below it leaves no room to any place
  /// of the half; negative: it leaves some beside.
  using Left = std::array<std::array<float, lanes>, 4>;

  struct Extent {
    Extent(const Cube& box, const Vec3& corner) {
      const Vec3 m = box.middle() - corner, half = (box.high - box.low) * 0.5;
      x = static_cast<float>(m.x), y = static_cast<float>(m.y), z = static_cast<float>(m.z);
      half_x = static_cast<float>(half.x), half_y = static_cast<float>(half.y);
      half_z = static_cast<float>(half.z);
    }
    float x, y, z, half_x, half_y, half_z;
  };

  Vec3 corner_;
  std::vector<Sample> samples_;
  std::vector<float> x_, y_, z_, radius_;  // of whole lanes
  // Of the column halved last: whether a sample covers the whole half, and what they leave.
  mutable std::array<unsigned, 4> covered_whole_{};
  mutable std::vector<Left> left_;
  mutable std::vector<std::array<float, 2>> covered_;
  mutable std::vector<std::array<double, 2>> taken_;  // by height_left
};

}  // namespace hoodoo::sampling
