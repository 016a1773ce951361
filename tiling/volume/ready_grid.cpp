#include "tiling/volume/ready_grid.hpp"

#include <algorithm>
#include <bit>
#include <vector>

#include "tiling/volume/lanes.hpp"

namespace hoodoo::volume {
namespace {

class Reader {
 public:
  Reader(const ReadyGrid& grid, Volume& volume) : grid_(grid), volume_(volume) {
    stride_ = {1, grid.size[0], static_cast<std::ptrdiff_t>(grid.size[0]) * grid.size[1]};
  }

  void run() {
    const auto& high = volume_.block_high();
    for (std::int64_t z = 0; z < high[2]; ++z) {
      for (std::int64_t y = 0; y < high[1]; ++y) {
        for (std::int64_t x = 0; x < high[0]; ++x) read_signs({x, y, z});
      }
    }
    volume_.mark();
    for (std::int64_t z = 0; z < high[2]; ++z) {
      for (std::int64_t y = 0; y < high[1]; ++y) {
        for (std::int64_t x = 0; x < high[0]; ++x) {
          if (volume_.block({x, y, z}) != nullptr) cross({x, y, z});
        }
      }
    }
  }

 private:
  using Place = std::array<int, 3>;

  Place place(const Index& b) const {
    return {static_cast<int>(16 * b[0]), static_cast<int>(16 * b[1]), static_cast<int>(16 * b[2])};
  }
  const float* at(const Place& p) const {
    return grid_.values.data() + stride_[2] * p[2] + stride_[1] * p[1] + p[0];
  }

  void read_signs(const Index& b) {
    const Place from = place(b);
    Place count{};
    for (std::size_t a = 0; a < 3; ++a) count[a] = std::min(16, grid_.size[a] - from[a]);
    std::array<std::uint16_t, 256> rows{};
    unsigned any = 0, all = 0xffff;
    const unsigned inside = (1U << count[0]) - 1;
    for (int z = 0; z < count[2]; ++z) {
      for (int y = 0; y < count[1]; ++y) {
        const float* row = at({from[0], from[1] + y, from[2] + z});
        std::array<float, 16> padded;
        if (count[0] < 16) {
          padded.fill(grid_.iso);
          std::copy(row, row + count[0], padded.begin());
          row = padded.data();
        }
        const unsigned bits = find_signs(std::span<const float, 16>(row, 16), grid_.iso);
        rows[static_cast<std::size_t>(16 * z + y)] = static_cast<std::uint16_t>(bits);
        any |= bits;
        all &= bits | ~inside;
      }
    }
    if (any == 0 || (all & inside) == inside) return volume_.set_uniform(b, any != 0);
    volume_.make_block(b).solid = rows;
  }

  /// The crossings of block `b`, in the order of its edges.
  void cross(const Index& b) {
    const Block& block = *volume_.block(b);
    const std::size_t n = block.crossings.size();
    if (n == 0) return;
    t_.clear();
    for (auto& along : uphill_) along.clear();
    const Place from = place(b);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int r = 0; r < 256; ++r) {
        for (unsigned bits = block.crossed[axis][static_cast<std::size_t>(r)]; bits != 0;
             bits &= bits - 1) {
          add({from[0] + std::countr_zero(bits), from[1] + (r & 15), from[2] + (r >> 4)}, axis);
        }
      }
    }
    for (auto& along : normal_) along.resize(n);
    point_against(uphill_[0], uphill_[1], uphill_[2], {normal_[0], normal_[1], normal_[2]});
    auto& crossings = volume_.make_block(b).crossings;
    for (std::size_t i = 0; i < n; ++i) {
      crossings[i] = {static_cast<float>(t_[i]), {normal_[0][i], normal_[1][i], normal_[2][i]}, 0};
    }
  }

  void add(const Place& p, std::size_t axis) {
    Place q = p;
    ++q[axis];
    const auto low = static_cast<double>(*at(p)), high = static_cast<double>(*at(q));
    const double t = (static_cast<double>(grid_.iso) - low) / (high - low);
    t_.push_back(t);
    for (std::size_t a = 0; a < 3; ++a) {
      const double here = slope(p, a), there = slope(q, a);
      uphill_[a].push_back(here + t * (there - here));
    }
  }

  double slope(const Place& p, std::size_t axis) const {
    const bool first = p[axis] == 0, last = p[axis] == grid_.size[axis] - 1;
    const float* here = at(p);
    const auto before = static_cast<double>(here[first ? 0 : -stride_[axis]]);
    const auto after = static_cast<double>(here[last ? 0 : stride_[axis]]);
    return (after - before) * (first || last ? 1.0 : 0.5);
  }

  const ReadyGrid& grid_;
  Volume& volume_;
  std::array<std::ptrdiff_t, 3> stride_{};
  std::vector<double> t_;
  std::array<std::vector<double>, 3> uphill_;
  std::array<std::vector<float>, 3> normal_;
};

}  // namespace

Volume volume_of(const ReadyGrid& grid) {
  Volume volume;
  read(grid, volume);
  return volume;
}

void read(const ReadyGrid& grid, Volume& volume) {
  volume.reset({0, 0, 0}, {grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1});
  Reader(grid, volume).run();
}

}  // namespace hoodoo::volume
