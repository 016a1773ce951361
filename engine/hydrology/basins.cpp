#include "engine/hydrology/basins.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hoodoo::hydrology {
namespace {

constexpr std::uint32_t not_known = std::uint32_t{1} << 31;  // a cell follows, no basin
constexpr std::uint8_t itself = 4, leaves = 9;

/// Of a cell and its neighbours, in the order of rows, the first of the lowest; `leaves` beside one
/// without an elevation. No branches, so that several cells are done at once.
void find_lowest(const float* above, const float* here, const float* below, std::size_t width,
                 std::uint8_t* where) {
  for (std::size_t i = 1; i + 1 < width; ++i) {
    float low = above[i - 1], sum = low;
    std::int32_t first = 0;
    const auto next = [&](float z, std::int32_t number) {
      sum += z;
      first = z < low ? number : first;
      low = z < low ? z : low;
    };
    next(above[i], 1), next(above[i + 1], 2);
    next(here[i - 1], 3), next(here[i], 4), next(here[i + 1], 5);
    next(below[i - 1], 6), next(below[i], 7), next(below[i + 1], 8);
    where[i] = static_cast<std::uint8_t>(sum == sum ? first : leaves);  // NaN is not itself
  }
}

/// Passes as they are met, each kept until another one takes its place: most are met again soon.
class Meeting {
 public:
  Meeting(std::vector<Pass>& passes, std::uint32_t basins) : passes_(passes), basins_(basins) {
    most_ = std::max<std::size_t>(std::size_t{1} << 18, 4 * std::size_t{basins});
    passes_.reserve(most_);
  }
  void meet(std::uint32_t a, std::uint32_t b, float level) {
    if (a > b) std::swap(a, b);
    auto& kept = recent_[(a * 0x9e3779b1U ^ b * 0x85ebca77U) >> shift];
    if (kept.a == a && kept.b == b) {
      kept.level = std::min(kept.level, level);
      return;
    }
    if (kept.a != kept.b) put(kept);
    kept = {a, b, level};
  }
  void finish() {
    for (const auto& pass : recent_) {
      if (pass.a != pass.b) put(pass);
    }
    passes_ = contracted(passes_, basins_, basins_);
  }

 private:
  void put(const Pass& pass) {
    if (passes_.size() >= most_) {
      passes_ = contracted(passes_, basins_, basins_);
      passes_.reserve(most_);
    }
    passes_.push_back(pass);
  }

  static constexpr int shift = 20;
  std::vector<Pass>& passes_;
  std::uint32_t basins_;
  std::size_t most_;
  std::vector<Pass> recent_ = std::vector<Pass>(std::size_t{1} << (32 - shift));
};

}  // namespace

Basins::Basins(const Ground& ground) : ground_(ground), basin_(ground.z.size()) {
  descend();
  follow();
  find_passes();
}

void Basins::descend() {
  const std::size_t last = ground_.height() - 1;
  // A part of one row may be the raster's first or last one, too: there water leaves.
  if (ground_.above && (last > 0 || ground_.below)) part_border(0);
  if (ground_.below && last > 0) part_border(last);
  on_borders_ = count_;
  std::vector<std::uint8_t> where(ground_.width);
  // In the raster's own first and last row water leaves.
  for (std::size_t j = 1; j < last; ++j) descend_from_row(j, where);
}

void Basins::part_border(std::size_t j) {
  for (std::size_t i = 0; i < ground_.width; ++i, ++count_) {
    const std::size_t cell = j * ground_.width + i;
    const bool at_edge = i == 0 || i + 1 == ground_.width;
    basin_[cell] = at_edge || std::isnan(ground_.z[cell]) ? outside : count_;
  }
}

void Basins::descend_from_row(std::size_t j, std::vector<std::uint8_t>& where) {
  const std::size_t width = ground_.width;
  if (width < 3) return;
  const float* here = ground_.z.data() + j * width;
  find_lowest(here - width, here, here + width, width, where.data());
  const auto wide = static_cast<std::uint32_t>(width);
  const std::array<std::uint32_t, 9> offset{0U - wide - 1, 0U - wide, 1U - wide, 0U - 1, 0, 1,
                                            wide - 1,      wide,      wide + 1};
  for (std::size_t i = 1; i + 1 < width; ++i) {
    const std::uint8_t at = where[i];
    auto& basin = basin_[j * width + i];
    if (at == leaves) continue;
    const auto cell = static_cast<std::uint32_t>(j * width + i);
    basin = at == itself ? count_++ : (cell + offset[at]) | not_known;
  }
}

void Basins::follow() {
  for (std::size_t first = 0; first < basin_.size(); ++first) {
    if ((basin_[first] & not_known) == 0) continue;
    std::size_t cell = first;
    while ((basin_[cell] & not_known) != 0) cell = basin_[cell] & ~not_known;
    const std::uint32_t basin = basin_[cell];
    for (cell = first; (basin_[cell] & not_known) != 0;) {
      const std::size_t next = basin_[cell] & ~not_known;
      basin_[cell] = basin;
      cell = next;
    }
  }
}

void Basins::find_passes() {
  Meeting meeting(passes_, count_);
  const std::size_t width = ground_.width;
  for (std::size_t cell = 0; cell < basin_.size(); ++cell) {
    const std::uint32_t* basin = basin_.data() + cell;
    const float* z = ground_.z.data() + cell;
    const auto meet = [&](std::size_t to) {
      if (basin[0] != basin[to]) meeting.meet(basin[0], basin[to], higher(z[0], z[to]));
    };
    const std::size_t i = cell % width;
    if (i + 1 < width) meet(1);
    if (cell + width >= basin_.size()) continue;
    if (i > 0) meet(width - 1);
    meet(width);
    if (i + 1 < width) meet(width + 1);
  }
  meeting.finish();
}

void Basins::raise(std::span<const float> levels) {
  for (std::size_t cell = 0; cell < basin_.size(); ++cell) {
    const float level = levels[basin_[cell]];
    float& z = ground_.z[cell];
    z = level > z ? level : z;
  }
}

}  // namespace hoodoo::hydrology
