#include "tiling/volume/volume.hpp"

#include <algorithm>
#include <bit>

namespace hoodoo::volume {

Volume::Volume(const Index& low, const Index& high) : low_(low), high_(high) {
  for (std::size_t a = 0; a < 3; ++a) {
    block_low_[a] = low[a] >> 4;
    block_high_[a] = (high[a] >> 4) + 1;
    size_[a] = block_high_[a] - block_low_[a];
  }
  in_world_.assign(static_cast<std::size_t>((high[0] - low[0] + 2) * (high[1] - low[1] + 2)), true);
  slots_.resize(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]));
}

void Volume::set_uniform(const Index& b, bool solid) {
  auto& slot = slots_[slot_of_block(b)];
  slot.block.reset();
  slot.solid = solid;
}

Block& Volume::make_block(const Index& b) {
  auto& slot = slots_[slot_of_block(b)];
  if (!slot.block) {
    slot.block = std::make_unique<Block>();
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
      for (int j = 0; j < 17; ++j) {
        std::uint32_t bits = 0;
        for (int i = 0; i < 17; ++i) {
          bits |= (meshed(16 * x + i - 1, 16 * y + j - 1) ? 1U : 0U) << i;
        }
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

void Volume::read_rows(const Index& b, Rows& rows) const {
  rows = {};
  for (std::size_t part = 0; part < 8; ++part) {
    const std::size_t dx = part & 1, dy = part >> 1 & 1, dz = part >> 2;
    const Index from{b[0] + static_cast<int>(dx), b[1] + static_cast<int>(dy),
                     b[2] + static_cast<int>(dz)};
    if (from[0] >= block_high_[0] || from[1] >= block_high_[1] || from[2] >= block_high_[2]) {
      continue;
    }
    const auto& slot = slots_[slot_of_block(from)];
    const std::uint32_t uniform = slot.solid ? 0xffffU : 0U, keep = dx == 0 ? 0xffffU : 1U;
    for (std::size_t z = 16 * dz; z < (dz == 0 ? 16U : 17U); ++z) {
      for (std::size_t y = 16 * dy; y < (dy == 0 ? 16U : 17U); ++y) {
        const std::uint32_t bits =
            slot.block ? slot.block->solid[(z & 15) * 16 + (y & 15)] : uniform;
        rows[z][y] |= (bits & keep) << (16 * dx);
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
  std::size_t count = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t r = 0; r < 256; ++r) {
      const std::size_t y = r & 15, z = r >> 4;
      const bool inside = (((a == 1 ? edges : points)[1] >> y) & 1) != 0 &&
                          (((a == 2 ? edges : points)[2] >> z) & 1) != 0;
      const auto own = rows[z][y];
      const auto next = a == 0 ? own >> 1 : a == 1 ? rows[z][y + 1] : rows[z + 1][y];
      // An edge counts where one of the cells around it is meshed.
      std::uint32_t near = meshed[y + 1] >> 1;
      if (a != 1) near |= meshed[y] >> 1;
      if (a != 0) near |= meshed[y + 1];
      if (a == 2) near |= meshed[y];
      const auto bits =
          inside ? (own ^ next) & near & (a == 0 ? edges : points)[0] : std::uint32_t{0};
      block.crossed[a][r] = static_cast<std::uint16_t>(bits);
      block.first[a][r] = static_cast<std::uint16_t>(count);
      if (bits != 0) count += count_bits(bits);
    }
  }
  block.crossings.assign(count, {});
  if (was_uniform && count == 0) set_uniform(b, (block.solid[0] & 1) != 0);
}

}  // namespace hoodoo::volume
