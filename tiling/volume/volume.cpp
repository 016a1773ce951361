#include "tiling/volume/volume.hpp"

#include <algorithm>
#include <bit>

#include "tiling/volume/lanes.hpp"

namespace hoodoo::volume {

void Volume::reset(const Index& low, const Index& high) {
  for (auto& slot : slots_) {
    if (slot.block) spare_.push_back(std::move(slot.block));
  }
  low_ = low;
  high_ = high;
  for (std::size_t a = 0; a < 3; ++a) {
    block_low_[a] = low[a] >> 4;
    block_high_[a] = (high[a] >> 4) + 1;
    size_[a] = block_high_[a] - block_low_[a];
  }
  in_world_.assign(static_cast<std::size_t>((high[0] - low[0] + 2) * (high[1] - low[1] + 2)), 1);
  slots_.clear();
  slots_.resize(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]));
  evaluations_ = 0;
}

void Volume::set_uniform(const Index& b, bool solid) {
  auto& slot = slots_[slot_of_block(b)];
  if (slot.block) spare_.push_back(std::move(slot.block));
  slot.solid = solid;
}

Block& Volume::make_block(const Index& b) {
  auto& slot = slots_[slot_of_block(b)];
  if (!slot.block) {
    if (spare_.empty()) spare_.push_back(std::make_unique<Block>());
    slot.block = std::move(spare_.back());
    spare_.pop_back();
    slot.block->solid.fill(static_cast<std::uint16_t>(slot.solid ? 0xffff : 0));
  }
  return *slot.block;
}

void Volume::set_solid(const Index& p, bool solid) {
  auto& bits = make_block({p[0] >> 4, p[1] >> 4, p[2] >> 4}).solid[row(p)];
  const auto bit = static_cast<std::uint16_t>(1U << (p[0] & 15));
  bits = static_cast<std::uint16_t>(solid ? bits | bit : bits & ~bit);
}

void Volume::find_meshed() {
  meshed_.assign(static_cast<std::size_t>(size_[0] * size_[1]), {});
  auto rows = meshed_.begin();
  for (std::int64_t y = block_low_[1]; y < block_high_[1]; ++y) {
    for (std::int64_t x = block_low_[0]; x < block_high_[0]; ++x, ++rows) {
      const std::int64_t first = 16 * x - 1;
      const auto from = std::max(low_[0], first), to = std::min(high_[0], first + 17);
      for (int j = 0; j < 17; ++j) {
        const std::int64_t row = 16 * y + j - 1;
        if (row < low_[1] || row >= high_[1] || from >= to) continue;
        const std::uint8_t* column = &in_world_[this->column(from, row)];
        std::uint32_t bits = 0;
        for (auto i = from; i < to; ++i) bits |= std::uint32_t{*column++} << (i - first);
        (*rows)[static_cast<std::size_t>(j)] = bits;
      }
    }
  }
}

void Volume::mark() {
  find_meshed();
  for (std::int64_t z = block_low_[2]; z < block_high_[2]; ++z) {
    for (std::int64_t y = block_low_[1]; y < block_high_[1]; ++y) {
      for (std::int64_t x = block_low_[0]; x < block_high_[0]; ++x) mark_block({x, y, z});
    }
  }
}

namespace {

/// The signs of a uniform block.
constexpr std::array<std::uint16_t, 256> air{};
constexpr auto rock = [] {
  std::array<std::uint16_t, 256> all{};
  all.fill(0xffff);
  return all;
}();

}  // namespace

void Volume::read_rows(const Index& b, Rows& rows) const {
  const auto signs_of = [&](std::size_t dx, std::size_t dy, std::size_t dz) {
    const Index from{b[0] + static_cast<int>(dx), b[1] + static_cast<int>(dy),
                     b[2] + static_cast<int>(dz)};
    const bool covered =
        from[0] < block_high_[0] && from[1] < block_high_[1] && from[2] < block_high_[2];
    if (!covered) return air.data();
    const auto& slot = slots_[slot_of_block(from)];
    return slot.block ? slot.block->solid.data() : slot.solid ? rock.data() : air.data();
  };
  for (std::size_t part = 0; part < 4; ++part) {
    const std::size_t dy = part & 1, dz = part >> 1;
    const std::uint16_t *own = signs_of(0, dy, dz), *next = signs_of(1, dy, dz);
    const std::size_t high = dy == 0 ? 16 : 1, deep = dz == 0 ? 16 : 1;
    for (std::size_t z = 0; z < deep; ++z) {
      std::uint32_t* to = &rows[16 * dz + z][16 * dy];
      for (std::size_t y = 0; y < high; ++y) {
        to[y] = own[16 * z + y] | (next[16 * z + y] & 1U) << 16;
      }
    }
  }
}

/// A uniform block can own a crossed edge only towards a neighbour of another kind.
bool Volume::may_be_crossed(const Index& b) const {
  const auto& slot = slots_[slot_of_block(b)];
  if (slot.block) return true;
  for (std::size_t a = 0; a < 3; ++a) {
    Index next = b;
    ++next[a];
    if (next[a] >= block_high_[a]) continue;
    const auto& n = slots_[slot_of_block(next)];
    if (n.block || n.solid != slot.solid) return true;
  }
  return false;
}

namespace {

/// Of 16 points from `first` on, those in the closed range [low, high], one bit each.
unsigned within(std::int64_t first, std::int64_t low, std::int64_t high) {
  const auto from = std::clamp<std::int64_t>(low - first, 0, 16);
  const auto to = std::clamp<std::int64_t>(high - first + 1, 0, 16);
  return to > from ? (1U << to) - (1U << from) : 0U;
}

}  // namespace

void Volume::mark_block(const Index& b) {
  if (!may_be_crossed(b)) return;
  const bool was_uniform = !slots_[slot_of_block(b)].block;
  Rows rows;
  read_rows(b, rows);
  Block& block = make_block(b);
  const auto& meshed = meshed_rows(b[0], b[1]);
  std::array<unsigned, 3> points{}, edges{};  // in the box: points, and edges from them on
  for (std::size_t a = 0; a < 3; ++a) {
    points[a] = within(16 * b[a], low_[a], high_[a]);
    edges[a] = within(16 * b[a], low_[a], high_[a] - 1);
  }
  // An edge counts where one of the cells around it is meshed.
  std::array<std::array<std::uint16_t, 16>, 3> near{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t y = 0; y < 16; ++y) {
      if (((a == 1 ? edges : points)[1] >> y & 1) == 0) continue;
      std::uint32_t cells = meshed[y + 1] >> 1;
      if (a != 1) cells |= meshed[y] >> 1;
      if (a != 0) cells |= meshed[y + 1];
      if (a == 2) cells |= meshed[y];
      near[a][y] = static_cast<std::uint16_t>(cells & (a == 0 ? edges : points)[0]);
    }
  }
  const std::size_t count = find_crossed(rows, near, {points[2], points[2], edges[2]}, block);
  block.crossings.resize(count);
  if (was_uniform && count == 0) set_uniform(b, (block.solid[0] & 1) != 0);
}

}  // namespace hoodoo::volume
