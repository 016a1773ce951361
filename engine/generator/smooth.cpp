#include "engine/generator/smooth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/tree/nodes/grid.hpp"

namespace hoodoo::generator {
namespace {

using tree::Voxel;
using tree::Voxels;
using Index = std::array<std::int64_t, 3>;

constexpr std::int64_t side = 16;   // points of a block along each axis
constexpr int widest = 8;           // steps of the lattice in `size`
constexpr double interpolated = 2;  // steps around a place from which voxels are read
constexpr std::size_t block_points = side * side * side;
constexpr std::int64_t most_blocks = std::int64_t{1} << 22;

/// Where F is sampled, and the weights of its mean along each axis.
struct Lattice {
  double step;  // [m]
  int reach;    // points to either side
  std::vector<double> weights;

  Lattice(double size, double spacing) : step(spacing) {
    while (size > widest * step) step *= 2;
    reach = static_cast<int>(std::ceil(size / step)) - 1;
    double sum = 0;
    for (int i = -reach; i <= reach; ++i) {
      const double t = i * step / size, q = 1 - t * t;
      weights.push_back(q * q * q);
      sum += weights.back();
    }
    for (double& w : weights) w /= sum;
  }
  std::int64_t block(double v) const {
    return static_cast<std::int64_t>(std::floor(v / (static_cast<double>(side) * step)));
  }
};

/// A range of blocks, both ends included.
struct Blocks {
  Index low, high;

  Blocks(const Lattice& lattice, const Box& box) {
    for (int a = 0; a < 3; ++a) {
      low[static_cast<std::size_t>(a)] = lattice.block(box.min[a]);
      high[static_cast<std::size_t>(a)] = lattice.block(box.max[a]);
    }
  }
  std::int64_t count(std::size_t axis) const { return high[axis] - low[axis] + 1; }
  std::size_t columns() const { return static_cast<std::size_t>(count(0) * count(1)); }
  std::size_t layers() const { return static_cast<std::size_t>(count(2)); }
  Index at(std::size_t column, std::size_t layer) const {
    const auto c = static_cast<std::int64_t>(column);
    return {low[0] + c % count(0), low[1] + c / count(0),
            low[2] + static_cast<std::int64_t>(layer)};
  }
  /// Place of a block in a list of all, column by column.
  std::size_t place(const Index& b) const {
    return static_cast<std::size_t>(((b[1] - low[1]) * count(0) + b[0] - low[0]) * count(2) + b[2] -
                                    low[2]);
  }
};

/// F in a block, z fastest; no values: one throughout.
struct Block {
  std::unique_ptr<std::array<float, block_points>> values;
  float one = 0;
  float at(std::size_t i) const { return values ? (*values)[i] : one; }
};

/// The scene so far, in blocks.
class Samples {
 public:
  Samples(const Site& site, const Lattice& lattice, const Box& box)
      : site_(site), lattice_(lattice), blocks_(lattice, box) {
    double all = 1;
    for (std::size_t a = 0; a < 3; ++a) all *= static_cast<double>(blocks_.count(a));
    if (all > static_cast<double>(most_blocks)) throw too_large();
    found_.resize(blocks_.columns() * blocks_.layers());
    // Beyond the world's edge there is no ground: what is at the edge goes on.
    const Box& world = site.extent();
    for (int a = 0; a < 2; ++a) {
      first_[static_cast<std::size_t>(a)] =
          static_cast<std::int64_t>(std::ceil(world.min[a] / lattice.step));
      last_[static_cast<std::size_t>(a)] =
          std::max(first_[static_cast<std::size_t>(a)],
                   static_cast<std::int64_t>(std::floor(world.max[a] / lattice.step)));
    }
    site.in_parallel(blocks_.columns(), [&](std::size_t column) { sample_column(column); });
  }

  std::size_t stored() const { return stored_; }

  /// The points from `from` on, `n` along each axis, z fastest. None: one value throughout, which
  /// is in `one`.
  bool gather(const Index& from, std::int64_t n, std::vector<double>& into, float& one) const {
    std::array<std::vector<std::int64_t>, 3> at;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::int64_t i = from[a]; i < from[a] + n; ++i) at[a].push_back(held(i, a));
    }
    if (is_uniform(at, one)) return false;
    into.clear();
    for (const auto x : at[0]) {
      for (const auto y : at[1]) {
        const Block* block = nullptr;
        for (const auto z : at[2]) {
          const std::int64_t k = inside(z);
          if (block == nullptr || k == 0) block = &found_[place(x, y, z)];
          const auto i = static_cast<std::size_t>((inside(x) * side + inside(y)) * side + k);
          into.push_back(static_cast<double>(block->at(i)));
        }
      }
    }
    return true;
  }

  static Error too_large() {
    return {Fault::limit, "",
            "smooths more than the memory holds: make the region smaller or "
            "\"size\" larger, or give more memory"};
  }

 private:
  static std::int64_t inside(std::int64_t i) { return ((i % side) + side) % side; }
  static std::int64_t block_of(std::int64_t i) { return (i - inside(i)) / side; }
  std::size_t place(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return blocks_.place({block_of(x), block_of(y), block_of(z)});
  }
  std::int64_t held(std::int64_t i, std::size_t axis) const {
    if (axis < 2) i = std::clamp(i, first_[axis], last_[axis]);
    return std::clamp(i, blocks_.low[axis] * side, blocks_.high[axis] * side + side - 1);
  }
  bool is_uniform(const std::array<std::vector<std::int64_t>, 3>& at, float& one) const {
    bool first = true;
    for (auto x = block_of(at[0].front()); x <= block_of(at[0].back()); ++x) {
      for (auto y = block_of(at[1].front()); y <= block_of(at[1].back()); ++y) {
        for (auto z = block_of(at[2].front()); z <= block_of(at[2].back()); ++z) {
          const Block& block = found_[blocks_.place({x, y, z})];
          if (block.values || (!first && block.one != one)) return false;
          one = block.one;
          first = false;
        }
      }
    }
    return true;
  }

  void sample_column(std::size_t column) {
    const double width = static_cast<double>(side) * lattice_.step;
    const auto corner = [&](const Index& b) {
      return Vec3{static_cast<double>(b[0]) * width, static_cast<double>(b[1]) * width,
                  static_cast<double>(b[2]) * width};
    };
    const Vec3 whole{width, width, width};
    const auto windows = site_.windows(
        {corner(blocks_.at(column, 0)), corner(blocks_.at(column, blocks_.layers() - 1)) + whole});
    std::array<float, side> along;
    for (std::size_t i = 0; i < along.size(); ++i) {
      along[i] = static_cast<float>(static_cast<double>(i) * lattice_.step);
    }
    for (std::size_t layer = 0; layer < blocks_.layers(); ++layer) {
      const Index b = blocks_.at(column, layer);
      const auto field = site_.compile(Box{corner(b), corner(b) + whole}, windows);
      Block& into = found_[blocks_.place(b)];
      const Interval bounds = field->bounds();
      into.one = static_cast<float>(bounds.low);
      if (bounds.low == bounds.high) continue;
      // As many again hold what is made of them.
      if ((++stored_ + 1) * 2 * sizeof *into.values > site_.spend().memory) throw too_large();
      into.values = std::make_unique<std::array<float, block_points>>();
      field->grid({along, along, along}, *into.values);
    }
  }

  const Site& site_;
  const Lattice& lattice_;
  Blocks blocks_;
  std::vector<Block> found_;
  std::array<std::int64_t, 2> first_{}, last_{};  // points of the world
  std::atomic<std::size_t> stored_{0};
};

/// The mean along the axis that is fastest, which comes to be the slowest: three times, and all
/// three axes are done and back in their order. `rows` of `n` values become as many of `side`.
std::vector<double> mean_along(const std::vector<double>& from, std::size_t n,
                               const std::vector<double>& weights) {
  const std::size_t rows = from.size() / n;
  std::vector<double> to(rows * side);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t i = 0; i < side; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * from[n * r + i + k];
      to[rows * i + r] = sum;
    }
  }
  return to;
}

/// One block of G: bricks and tiles of voxels.
struct Smoothed {
  Voxel from{};
  std::optional<float> one;    // throughout
  std::vector<double> values;  // else z fastest
};

Smoothed smoothed(const Samples& samples, const Lattice& lattice, const Index& block) {
  Smoothed made;
  Index from;
  for (std::size_t a = 0; a < 3; ++a) {
    made.from[a] = static_cast<std::int32_t>(block[a] * side);
    from[a] = block[a] * side - lattice.reach;
  }
  const auto n = side + 2 * lattice.reach;
  float one = 0;
  if (!samples.gather(from, n, made.values, one)) {
    made.one = one;
    return made;
  }
  for (int axis = 0; axis < 3; ++axis) {
    made.values = mean_along(made.values, static_cast<std::size_t>(n), lattice.weights);
  }
  return made;
}

void put(const Smoothed& made, Voxels::Builder& builder) {
  constexpr std::int32_t brick = Voxels::brick_side;
  for (std::int32_t b = 0; b < 8; ++b) {
    const Voxel at{b / 4 * brick, b / 2 % 2 * brick, b % 2 * brick};
    const Voxel from{made.from[0] + at[0], made.from[1] + at[1], made.from[2] + at[2]};
    if (made.one) {
      builder.tile(from, 0, *made.one);
      continue;
    }
    std::array<float, Voxels::brick_size> values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto v = static_cast<std::int64_t>(i);
      const auto x = at[0] + v / (brick * brick), y = at[1] + v / brick % brick;
      const auto z = at[2] + v % brick;
      values[i] =
          static_cast<float>(made.values[static_cast<std::size_t>((x * side + y) * side + z)]);
    }
    builder.brick(from, values);
  }
}

/// Where it acts: the region as far as there is a surface to smooth.
tree::Region bounded(const Growth& growth, const Box& reach, double beyond) {
  tree::Region region = growth.region ? *growth.region : tree::Region();
  region.box = intersection(region.box, reach.grown(beyond + region.feather));
  return region;
}

}  // namespace

void Smooth::grow(Growth& growth) const {
  const double spacing = growth.site.spacing();
  if (size < 2 * spacing) {
    throw Error(Fault::bad_input, "/size",
                fmt::format("must be at least two spacings, {} m, got {}", 2 * spacing, size));
  }
  const Lattice lattice(size, spacing);
  const Box reach = growth.reach();
  if (reach.empty()) return;
  const auto region = bounded(growth, reach, size + 4 * lattice.step);
  const Box voxels = region.influence().grown(interpolated * lattice.step);
  if (voxels.empty()) return;
  const Blocks blocks(lattice, voxels);
  const Samples samples(growth.site, lattice, voxels.grown((side + lattice.reach) * lattice.step));
  Voxels::Builder builder;
  std::size_t changed = 0;
  std::vector<Smoothed> row(static_cast<std::size_t>(blocks.count(0)) * blocks.layers());
  for (std::int64_t j = 0; j < blocks.count(1); ++j) {
    const auto first = static_cast<std::size_t>(j * blocks.count(0));
    growth.site.in_parallel(row.size(), [&](std::size_t i) {
      const auto b = blocks.at(first + i / blocks.layers(), i % blocks.layers());
      row[i] = smoothed(samples, lattice, b);
    });
    for (const auto& one : row) {
      changed += one.one ? 0 : 1;
      put(one, builder);
    }
  }
  growth.record.count("blocks sampled", samples.stored());
  growth.record.count("blocks smoothed", changed);
  if (changed == 0) return;
  tree::VoxelGrid grid;
  Voxels::Placement placement;
  for (std::size_t a = 0; a < 3; ++a) placement.linear[a][a] = lattice.step;
  grid.voxels = builder.finish(placement, 0);
  grid.file = "sha256:" + grid.voxels.digest().hex();
  grid.interpolation = tree::VoxelGrid::Interpolation::quadratic;
  growth.add(tree::Operation::replace, {std::move(grid), {}},
             std::make_shared<const tree::Region>(region));
}

}  // namespace hoodoo::generator
