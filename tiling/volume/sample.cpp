#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine/dem/window.hpp"
#include "engine/tree/field.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/reach.hpp"
#include "engine/tree/region.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/volume/crossings.hpp"
#include "tiling/volume/lanes.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {
namespace {

/// Blocks whose values wait for their crossings: 8 MiB.
constexpr std::size_t most_kept = 512;

/// Points of one block that the volume's closed box holds, as [from, to) local indices.
struct Part {
  std::array<int, 3> from, to;
  bool empty() const { return from[0] >= to[0] || from[1] >= to[1] || from[2] >= to[2]; }
  bool whole() const { return from == std::array{0, 0, 0} && to == std::array{16, 16, 16}; }
};
Part part_of(const Volume& volume, const Index& b) {
  Part part{};
  for (std::size_t a = 0; a < 3; ++a) {
    part.from[a] = static_cast<int>(std::max<std::int64_t>(volume.low()[a] - 16 * b[a], 0));
    part.to[a] = static_cast<int>(std::min<std::int64_t>(volume.high()[a] - 16 * b[a], 15)) + 1;
  }
  return part;
}

/// Fills one volume from a land.
class Sampler {
 public:
  Sampler(slice::Land& land, Volume& volume)
      : land_(land), volume_(volume), spacing_(land.slice().spacing()), relief_(volume, spacing_) {
    const auto& high = volume.block_high();
    kept_.resize(place_of({high[0] - 1, high[1] - 1, high[2] - 1}) + 1);
  }

  void run() {
    for (std::int64_t y = volume_.block_low()[1]; y < volume_.block_high()[1]; ++y) {
      for (std::int64_t x = volume_.block_low()[0]; x < volume_.block_high()[0]; ++x) {
        sample_column(x, y);
      }
    }
    volume_.mark();
    CrossingFinder finder(land_, volume_, relief_);
    // Column by column: blocks above each other share their elevations.
    for (std::int64_t y = volume_.block_low()[1]; y < volume_.block_high()[1]; ++y) {
      for (std::int64_t x = volume_.block_low()[0]; x < volume_.block_high()[0]; ++x) {
        for (std::int64_t z = volume_.block_low()[2]; z < volume_.block_high()[2]; ++z) {
          const Index b{x, y, z};
          if (volume_.block(b) == nullptr) continue;
          const auto known = std::move(kept_[place_of(b)]);
          finder.find(b, known.get());
        }
      }
    }
    finder.finish();
  }

 private:
  Vec3 origin(const Index& b) const {
    const double size = 16 * spacing_;
    return {static_cast<double>(b[0]) * size, static_cast<double>(b[1]) * size,
            static_cast<double>(b[2]) * size};
  }

  /// A meshed cell touches a point of block column (x, y).
  bool column_matters(std::int64_t x, std::int64_t y) const {
    for (std::int64_t j = 16 * y - 1; j < 16 * y + 16; ++j) {
      for (std::int64_t i = 16 * x - 1; i < 16 * x + 16; ++i) {
        if (volume_.meshed(i, j)) return true;
      }
    }
    return false;
  }

  void sample_column(std::int64_t x, std::int64_t y) {
    if (!column_matters(x, y)) return;
    columns_.clear();
    const auto surface = surface_of_column(x, y);
    for (std::int64_t z = volume_.block_low()[2]; z < volume_.block_high()[2]; ++z) {
      const double bottom = origin({x, y, z}).z, top = bottom + 16 * spacing_;
      if (surface && bottom > surface->high + spacing_) {
        volume_.set_uniform({x, y, z}, false);
      } else if (surface && top < surface->low - spacing_) {
        volume_.set_uniform({x, y, z}, true);
      } else {
        sample_block({x, y, z});
      }
    }
  }

  /// The z [m] between which all of the surface in a block column lies, where the ground is one
  /// height field and steps that can only act where their trees reach: blocks beyond need no field.
  std::optional<Interval> surface_of_column(std::int64_t x, std::int64_t y) const {
    const auto& ground = land_.slice().ground;
    if (ground.bodies.size() != 1 || land_.is_closed()) return std::nullopt;
    const auto& body = ground.bodies[0];
    // With a falloff beyond this, single precision may not tell solid from air a cell away.
    const bool plain = !body.inverted && body.domain.empty() && !body.slope_corrected &&
                       body.falloff < 1e5 * spacing_;
    if (!plain) return std::nullopt;
    Box column{origin({x, y, volume_.block_low()[2]}),
               origin({x + 1, y + 1, volume_.block_high()[2]})};
    Interval range = land_.heights(column);
    if (range.low > range.high) return std::nullopt;
    for (const tree::Step& step : ground.steps) {
      if (tree::acts_by_zero(step.operation)) return std::nullopt;
      const auto reach = tree::reach_over(step, column.grown(spacing_));
      if (!reach.empty()) range = hull(range, reach.z);
    }
    return range;
  }

  void sample_block(const Index& b) {
    const Part part = part_of(volume_, b);
    if (part.empty()) return;
    const tree::Field& field = land_.field({b[0], b[1], b[2]});
    const Interval bounds = field.bounds();
    if (bounds.high <= iso_value || bounds.low > iso_value) {
      volume_.set_uniform(b, bounds.low > iso_value);
      return;
    }
    if (const dem::Window* window = field.height_field()) {
      sample_heights(b, part, *window);
    } else {
      sample_field(b, part, field);
    }
  }

  void sample_heights(const Index& b, const Part& part, const dem::Window& window) {
    std::array<std::uint16_t, 256> rows;
    find_signs(relief_.at(b[0], b[1], window).h, origin(b).z, spacing_, rows);
    put_signs(b, part, rows);
  }

  /// Keeps the part's rows. A block whose points are all alike is not stored.
  void put_signs(const Index& b, const Part& part, const std::array<std::uint16_t, 256>& rows) {
    const unsigned inside = (1U << part.to[0]) - (1U << part.from[0]);
    unsigned any = 0, all = inside;
    for (int k = part.from[2]; k < part.to[2]; ++k) {
      for (int j = part.from[1]; j < part.to[1]; ++j) {
        const unsigned row = rows[static_cast<std::size_t>(16 * k + j)];
        any |= row & inside;
        all &= row;
      }
    }
    if (any == 0 || all == inside) return volume_.set_uniform(b, any != 0);
    Block& block = volume_.make_block(b);
    for (int k = part.from[2]; k < part.to[2]; ++k) {
      for (int j = part.from[1]; j < part.to[1]; ++j) {
        const auto r = static_cast<std::size_t>(16 * k + j);
        block.solid[r] = static_cast<std::uint16_t>(rows[r] & inside);
      }
    }
  }

  void sample_field(const Index& b, const Part& part, const tree::Field& field) {
    const auto place = [&](std::vector<float>& along, std::size_t axis) {
      along.clear();
      for (int i = part.from[axis]; i < part.to[axis]; ++i) {
        along.push_back(static_cast<float>(i * spacing_));
      }
    };
    place(x_, 0), place(y_, 1), place(z_, 2);
    const tree::Grid grid{x_, y_, z_};
    std::array<std::uint16_t, 256> rows{};
    if (part.whole()) {
      volume_.add_evaluations(field.grid(grid, values_, &columns_));
      find_signs(values_, rows);
    } else {
      value_.resize(grid.size());
      volume_.add_evaluations(field.grid(grid, value_, &columns_));
      find_part_signs(part, rows);
    }
    put_signs(b, part, rows);
    if (part.whole() && volume_.block(b) != nullptr) keep_values(b);
  }

  void find_part_signs(const Part& part, std::array<std::uint16_t, 256>& rows) const {
    std::size_t n = 0;
    for (int i = part.from[0]; i < part.to[0]; ++i) {
      for (int j = part.from[1]; j < part.to[1]; ++j) {
        for (int k = part.from[2]; k < part.to[2]; ++k, ++n) {
          auto& row = rows[static_cast<std::size_t>(16 * k + j)];
          if (value_[n] > static_cast<float>(iso_value))
            row = static_cast<std::uint16_t>(row | 1U << i);
        }
      }
    }
  }
  /// Values at the ends of edges need not be found again.
  void keep_values(const Index& b) {
    if (kept_count_ == most_kept) return;
    ++kept_count_;
    kept_[place_of(b)] = std::make_unique<BlockValues>(values_);
  }
  std::size_t place_of(const Index& b) const {
    const auto& low = volume_.block_low();
    const auto& high = volume_.block_high();
    return static_cast<std::size_t>(((b[2] - low[2]) * (high[1] - low[1]) + b[1] - low[1]) *
                                        (high[0] - low[0]) +
                                    b[0] - low[0]);
  }

  slice::Land& land_;
  Volume& volume_;
  double spacing_;
  ReliefColumns relief_;
  tree::Columns columns_;  // of the block column at hand
  std::vector<float> x_, y_, z_, value_;
  BlockValues values_;
  std::vector<std::unique_ptr<BlockValues>> kept_;  // by block
  std::size_t kept_count_ = 0;
};

/// Whole blocks of z, in cells, that hold every surface over the tile.
std::array<std::int64_t, 2> z_cells(const slice::Land& land) {
  const auto& slice = land.slice();
  Box area = slice.lattice.area(slice.key).grown(slice.spacing());
  Interval range = land.heights(area);
  // Step by step, since one without a bound must not hide where another ends.
  for (const tree::Step& step : slice.ground.steps) {
    Box reach = tree::support(step.tree).influence;
    if (step.region) reach = intersection(reach, step.region->influence());
    if (reach.empty()) continue;
    if (std::isfinite(reach.min.z)) range.low = std::min(range.low, reach.min.z);
    if (std::isfinite(reach.max.z)) range.high = std::max(range.high, reach.max.z);
  }
  if (!(range.low <= range.high)) return {0, 16};
  if (slice.floor) range.low = std::min(range.low, *slice.floor);
  const double block = 16 * slice.spacing();
  const auto low = static_cast<std::int64_t>(std::floor((range.low - slice.spacing()) / block));
  const auto high = static_cast<std::int64_t>(std::ceil((range.high + slice.spacing()) / block));
  return {16 * low, 16 * std::max(high, low + 1)};
}

}  // namespace

Volume sample(slice::Land& land) {
  Volume volume;
  sample(land, volume);
  return volume;
}

void sample(slice::Land& land, Volume& volume) {
  const auto& slice = land.slice();
  const std::int64_t cells = slice.lattice.tile_cells;
  const auto z = z_cells(land);
  volume.reset({slice.key.x * cells, slice.key.y * cells, z[0]},
               {(slice.key.x + 1) * cells, (slice.key.y + 1) * cells, z[1]});
  const auto wide = static_cast<std::size_t>(cells + 2);
  land.in_world(volume.low()[0] - 1, volume.low()[1] - 1, wide, volume.in_world());
  bool any = false;
  for (std::int64_t j = volume.low()[1]; j < volume.high()[1] && !any; ++j) {
    for (std::int64_t i = volume.low()[0]; i < volume.high()[0] && !any; ++i) {
      any = volume.meshed(i, j);
    }
  }
  if (any) Sampler(land, volume).run();
}

}  // namespace hoodoo::volume
