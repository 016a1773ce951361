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

bool Volume::touches_meshed(int axis, const Index& p) const {
  const auto [i, j, k] = p;
  if (axis == 2) {
    return meshed(i, j) || meshed(i - 1, j) || meshed(i, j - 1) || meshed(i - 1, j - 1);
  }
  return meshed(i, j) || (axis == 0 ? meshed(i, j - 1) : meshed(i - 1, j));
}

void Volume::mark() {
  for (std::int64_t z = block_low_[2]; z < block_high_[2]; ++z) {
    for (std::int64_t y = block_low_[1]; y < block_high_[1]; ++y) {
      for (std::int64_t x = block_low_[0]; x < block_high_[0]; ++x) mark_block({x, y, z});
    }
  }
}

unsigned Volume::solid_row(const Index& b, int r) const {
  const auto& slot = slots_[slot_of_block(b)];
  return slot.block ? slot.block->solid[static_cast<std::size_t>(r)] : slot.solid ? 0xffffU : 0U;
}

unsigned Volume::differing(int axis, const Index& b, int r) const {
  const auto a = static_cast<std::size_t>(axis);
  const std::int64_t y = 16 * b[1] + (r & 15), z = 16 * b[2] + (r >> 4);
  if (y < low_[1] || z < low_[2] || y > high_[1] || z > high_[2]) return 0;
  if ((axis == 1 && y == high_[1]) || (axis == 2 && z == high_[2])) return 0;
  const unsigned own = solid_row(b, r);
  // Points of the row in the box whose next point along the axis is, too.
  const auto from = std::max<std::int64_t>(low_[0] - 16 * b[0], 0);
  const auto to = std::min<std::int64_t>(high_[0] - 16 * b[0] + (axis == 0 ? 0 : 1), 16);
  const unsigned inside = to > from ? (1U << to) - (1U << from) : 0U;
  Index beyond = b;
  ++beyond[a];
  unsigned next = 0;
  if (axis == 0) {
    const bool last = beyond[0] >= block_high_[0];
    next = own >> 1 | (last ? 0U : (solid_row(beyond, r) & 1U) << 15);
  } else {
    const int step = axis == 1 ? 1 : 16;
    const bool within = axis == 1 ? (r & 15) < 15 : r < 240;
    next = within ? solid_row(b, r + step) : solid_row(beyond, r - 15 * step);
  }
  return (own ^ next) & inside;
}

void Volume::mark_block(const Index& b) {
  const auto index = slot_of_block(b);
  // A uniform block can own a crossed edge only towards a neighbour of another kind.
  if (!slots_[index].block) {
    bool differs = false;
    for (std::size_t a = 0; a < 3; ++a) {
      Index next = b;
      ++next[a];
      if (next[a] >= block_high_[a]) continue;
      const auto& n = slots_[slot_of_block(next)];
      differs = differs || n.block || n.solid != slots_[index].solid;
    }
    if (!differs) return;
  }
  const bool was_uniform = !slots_[index].block;
  Block& block = make_block(b);
  std::uint16_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (int r = 0; r < 256; ++r) {
      std::uint16_t bits = 0;
      Index p{16 * b[0], 16 * b[1] + (r & 15), 16 * b[2] + (r >> 4)};
      for (unsigned left = differing(axis, b, r); left != 0; left &= left - 1) {
        const int x = std::countr_zero(left);
        p[0] = 16 * b[0] + x;
        if (touches_meshed(axis, p)) bits = static_cast<std::uint16_t>(bits | 1U << x);
      }
      block.crossed[a][static_cast<std::size_t>(r)] = bits;
      block.first[a][static_cast<std::size_t>(r)] = count;
      count = static_cast<std::uint16_t>(count + std::popcount(bits));
    }
  }
  block.crossings.assign(count, {});
  if (was_uniform && count == 0) {
    const bool solid = (block.solid[0] & 1) != 0;
    set_uniform(b, solid);
  }
}

}  // namespace hoodoo::volume
