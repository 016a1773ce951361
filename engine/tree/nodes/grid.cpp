#include "engine/tree/nodes/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/tree/composite.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {
namespace {

constexpr double least_span = 1e-9;         // between `low` and `high`
constexpr double far = 1 << 30;             // lattice coordinates are held here: nothing is set
constexpr double steepest_gradient = 1e30;  // [1/m]

/// The voxels in reach of a point along one axis, with their weights and the weights' slopes.
struct Taps {
  std::int32_t first = 0;
  std::array<double, 3> weight{}, slope{};
};

/// What `node.interpolation` reads: how many voxels along an axis, and how far from a point.
struct Reach {
  int taps;
  double distance;
};
Reach reach_of(const VoxelGrid& node) {
  return node.interpolation == VoxelGrid::Interpolation::linear ? Reach{2, 1} : Reach{3, 1.5};
}

Matrix inverse(const Matrix& m) {
  const auto minor = [&](std::size_t r, std::size_t c) {
    const std::size_t i = (r + 1) % 3, j = (r + 2) % 3, k = (c + 1) % 3, l = (c + 2) % 3;
    return m[i][k] * m[j][l] - m[i][l] * m[j][k];
  };
  const double det = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  Matrix inverted;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) inverted[r][c] = minor(c, r) / det;
  }
  return inverted;
}

/// A node's voxels in the scene: where they lie and what their values become.
struct Placed {
  const VoxelGrid& node;
  Matrix outward;  // lattice -> scene, about `start`
  Matrix inward;
  Vec3 start;  // of voxel 0, 0, 0
  double outside;

  explicit Placed(const VoxelGrid& n) : node(n) {
    const auto& placement = node.voxels.placement();
    const Vec3 shift = turned(placement.shift);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& l = placement.linear;
      const Vec3 column = turned({l[0][c], l[1][c], l[2][c]});
      for (std::size_t r = 0; r < 3; ++r) outward[r][c] = column[static_cast<int>(r)];
    }
    inward = inverse(outward);
    start = node.origin.value + shift;
    // Single precision, as the voxels, so that bounds hold it exactly.
    outside = static_cast<double>(static_cast<float>(
        node.background.value_or(static_cast<double>(node.voxels.background()))));
  }

  Vec3 turned(const Vec3& v) const {
    return (node.up == VoxelGrid::Up::z ? v : Vec3{v.x, -v.z, v.y}) * node.metres;
  }
  double part(double v) const { return (v - node.low) / (node.high - node.low); }
  double value(double v) const { return node.energy * std::clamp(part(v), 0.0, 1.0); }
  bool zero_outside() const { return value(outside) == 0; }

  /// Of the values of some voxels.
  Interval values(VoxelRange range) const {
    if (range.gaps) range.add(static_cast<float>(outside));
    const double a = value(static_cast<double>(range.low));
    const double b = value(static_cast<double>(range.high));
    return {std::min(a, b), std::max(a, b)};
  }

  /// First voxel in reach of a lattice coordinate.
  std::int32_t first(double u) const {
    const bool linear = node.interpolation == VoxelGrid::Interpolation::linear;
    return static_cast<std::int32_t>(std::floor(linear ? u : u - 0.5));
  }

  Taps taps(double u) const {
    Taps taps;
    taps.first = first(u);
    if (node.interpolation == VoxelGrid::Interpolation::linear) {
      const double t = u - taps.first;
      taps.weight = {1 - t, t, 0};
      taps.slope = {-1, 1, 0};
    } else {
      const double t = u - taps.first - 1;  // in [-1/2, 1/2]
      taps.weight = {0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)};
      taps.slope = {t - 0.5, -2 * t, t + 0.5};
    }
    return taps;
  }
};

double lattice(double u) { return std::clamp(u, -far, far); }

class GridKernel final : public Kernel {
 public:
  GridKernel(const VoxelGrid& node, const Vec3& origin)
      : node_(node), placed_(node_), from_(origin - placed_.start) {}

  void values(const Points& at, std::span<float> out) const override {
    Voxels::Cursor cursor(node_.voxels);
    for (std::size_t i = 0; i < at.size(); ++i) {
      out[i] = static_cast<float>(placed_.value(read<false>(cursor, at, i).v));
    }
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    Voxels::Cursor cursor(node_.voxels);
    const double steep = node_.energy / (node_.high - node_.low);
    const Matrix& a = placed_.inward;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Dual<double> d = read<true>(cursor, at, i);
      const double part = placed_.part(d.v);
      const double s = part > 0 && part < 1 ? steep : 0;
      const auto along = [&](std::size_t c) {
        const double slope = s * (d.x * a[0][c] + d.y * a[1][c] + d.z * a[2][c]);
        return static_cast<float>(std::clamp(slope, -steepest_gradient, steepest_gradient));
      };
      out[i] = static_cast<float>(placed_.value(d.v));
      g.x[i] = along(0);
      g.y[i] = along(1);
      g.z[i] = along(2);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, VoxelGrid::type));
  }

 private:
  /// The value at a point and, if asked for, its gradient in lattice coordinates.
  template <bool slopes>
  Dual<double> read(Voxels::Cursor& cursor, const Points& at, std::size_t i) const {
    const Vec3 p = from_ + Vec3{static_cast<double>(at.x[i]), static_cast<double>(at.y[i]),
                                static_cast<double>(at.z[i])};
    const Vec3 u = placed_.inward * p;
    const int n = reach_of(node_).taps;
    std::array<Taps, 3> taps;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      taps[axis] = placed_.taps(lattice(u[static_cast<int>(axis)]));
      if (taps[axis].first > node_.voxels.high()[axis] ||
          taps[axis].first + n - 1 < node_.voxels.low()[axis]) {
        return placed_.outside;
      }
    }
    return sum<slopes>(cursor, taps, n);
  }

  /// Sums along z, then y, then x.
  template <bool slopes>
  Dual<double> sum(Voxels::Cursor& cursor, const std::array<Taps, 3>& taps, int n) const {
    Dual<double> all;
    const auto& [x, y, z] = taps;
    for (int i = 0; i < n; ++i) {
      const auto a = static_cast<std::size_t>(i);
      Dual<double> plane;
      for (int j = 0; j < n; ++j) {
        const auto b = static_cast<std::size_t>(j);
        Dual<double> row;
        for (int k = 0; k < n; ++k) {
          const auto c = static_cast<std::size_t>(k);
          const float stored = cursor.at(x.first + i, y.first + j, z.first + k);
          const double v = std::isnan(stored) ? placed_.outside : static_cast<double>(stored);
          row.v += z.weight[c] * v;
          if constexpr (slopes) row.z += z.slope[c] * v;
        }
        plane.v += y.weight[b] * row.v;
        if constexpr (slopes) {
          plane.y += y.slope[b] * row.v;
          plane.z += y.weight[b] * row.z;
        }
      }
      all.v += x.weight[a] * plane.v;
      if constexpr (slopes) {
        all.x += x.slope[a] * plane.v;
        all.y += x.weight[a] * plane.y;
        all.z += x.weight[a] * plane.z;
      }
    }
    return all;
  }

  VoxelGrid node_;
  Placed placed_;
  Vec3 from_;  // the block's origin, seen from voxel 0, 0, 0
};

/// The voxels that points of a box can read; both corners included.
std::pair<Voxel, Voxel> in_reach(const Placed& placed, const Box& box) {
  const Vec3 middle = (box.min + box.max) * 0.5 - placed.start, half = (box.max - box.min) * 0.5;
  const int more = reach_of(placed.node).taps - 1;
  Voxel from, to;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& row = placed.inward[axis];
    double centre = 0, spread = 0, size = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const int i = static_cast<int>(c);
      centre += row[c] * middle[i];
      spread += std::abs(row[c]) * half[i];
      size += std::abs(row[c] * middle[i]);
    }
    const double reach = spread + 1e-9 * (1 + size + spread);  // more than double has rounded
    from[axis] = placed.first(lattice(centre - reach));
    to[axis] = placed.first(lattice(centre + reach)) + more;
  }
  return {from, to};
}

bool misses(const Voxels& voxels, const std::pair<Voxel, Voxel>& box) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box.first[axis] > voxels.high()[axis] || box.second[axis] < voxels.low()[axis]) return true;
  }
  return false;
}

}  // namespace

void VoxelGrid::check(const std::string& where, std::vector<Problem>& problems) const {
  if (std::abs(high - low) >= least_span) return;
  problems.push_back(
      {where + "/high", fmt::format("must differ from \"low\" by {} at least, got {} and {}",
                                    least_span, high, low)});
}

Support VoxelGrid::support(std::span<const Support>) const {
  if (voxels.empty()) return {Box(), {0, 0}, 0};
  const Placed placed(*this);
  Support all{Box::everywhere(), placed.values(voxels.range()), 0};
  if (placed.zero_outside()) {
    const auto side = [&](const Voxel& v, double by) {
      return Vec3{v[0] + by, v[1] + by, v[2] + by};
    };
    const double reach = reach_of(*this).distance;
    all.influence = mapped(Box{side(voxels.low(), -reach), side(voxels.high(), reach)},
                           [&](const Vec3& v) { return placed.start + placed.outward * v; });
  }
  // Along each axis of the lattice neighbours differ by no more than all values do.
  VoxelRange range = voxels.range();
  range.add(static_cast<float>(placed.outside));
  double squares = 0;
  for (const auto& row : placed.inward) {
    for (const double v : row) squares += v * v;
  }
  all.slope = std::abs(energy / (high - low)) *
              (static_cast<double>(range.high) - static_cast<double>(range.low)) *
              std::sqrt(3 * squares);
  return all;
}

/// Bounds by the value at the centre of a box and the steepest slope there is.
static Interval about_centre(const VoxelGrid& node, const Box& box) {
  const Vec3 center = (box.min + box.max) * 0.5;
  const float zero = 0;
  float value = 0;
  GridKernel(node, center).values({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {&value, 1});
  const double change = node.support({}).slope * length(box.max - box.min) / 2;
  return {static_cast<double>(value) - change, static_cast<double>(value) + change};
}

Compiled VoxelGrid::compile_node(const std::vector<Node>&, const Block& block) const {
  if (voxels.empty()) return {};
  const Placed placed(*this);
  const auto reach = in_reach(placed, block.box.grown(rounding(block.box, block)));
  VoxelRange range;
  range.gaps = true;
  if (misses(voxels, reach)) {
    if (placed.zero_outside()) return {};
  } else {
    range = voxels.range(reach.first, reach.second);
  }
  const Interval near = about_centre(*this, block.box);
  const Interval all = placed.values(range);
  return {std::make_unique<GridKernel>(*this, block.origin),
          outward({std::max(all.low, near.low), std::min(all.high, near.high)})};
}

Node VoxelGrid::prune_node(const std::vector<Node>&, const Box& reach, double) const {
  return reaches(support({}).influence, reach) ? Node{*this, {}} : nothing();
}

}  // namespace hoodoo::tree
