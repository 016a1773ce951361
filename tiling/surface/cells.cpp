#include "tiling/surface/cells.hpp"

#include <algorithm>

#include "tiling/surface/qef.hpp"
#include "tiling/surface/snap.hpp"

namespace hoodoo::surface {

using volume::Index;

Cells::Cells(const volume::Volume& volume, int units, Surface& out)
    : volume_(volume), units_(units), out_(out) {
  const auto& low = volume.block_low();
  const auto& high = volume.block_high();
  groups_.resize(group_of({high[0] - 1, high[1] - 1, high[2] - 1}) + 1);
  for (std::int64_t z = low[2]; z < high[2]; ++z) {
    for (std::int64_t y = low[1]; y < high[1]; ++y) {
      for (std::int64_t x = low[0]; x < high[0]; ++x) {
        if (may_hold_surface({x, y, z})) add_group({x, y, z});
      }
    }
  }
}

std::size_t Cells::group_of(const Index& b) const {
  const auto& low = volume_.block_low();
  const auto& high = volume_.block_high();
  return static_cast<std::size_t>(((b[2] - low[2]) * (high[1] - low[1]) + (b[1] - low[1])) *
                                      (high[0] - low[0]) +
                                  (b[0] - low[0]));
}

/// The cells of a group reach into the seven blocks beyond it; every crossed edge is owned by a
/// stored block.
bool Cells::may_hold_surface(const Index& b) const {
  const auto& high = volume_.block_high();
  for (std::int64_t z = b[2]; z < std::min(b[2] + 2, high[2]); ++z) {
    for (std::int64_t y = b[1]; y < std::min(b[1] + 2, high[1]); ++y) {
      for (std::int64_t x = b[0]; x < std::min(b[0] + 2, high[0]); ++x) {
        if (volume_.block({x, y, z}) != nullptr) return true;
      }
    }
  }
  return false;
}

void Cells::read_rows(const Index& b, Rows& rows) const {
  const auto& high = volume_.block_high();
  for (std::size_t half = 0; half < 8; ++half) {
    const std::size_t dx = half & 1, dy = half >> 1 & 1, dz = half >> 2;
    const Index from{b[0] + static_cast<int>(dx), b[1] + static_cast<int>(dy),
                     b[2] + static_cast<int>(dz)};
    if (from[0] >= high[0] || from[1] >= high[1] || from[2] >= high[2]) continue;
    const volume::Block* block = volume_.block(from);
    const std::uint32_t uniform = block == nullptr && volume_.uniform_solid(from) ? 0xffffU : 0U;
    const std::uint32_t keep = dx == 0 ? 0xffffU : 1U;
    for (std::size_t z = 16 * dz; z < (dz == 0 ? 16U : 17U); ++z) {
      for (std::size_t y = 16 * dy; y < (dy == 0 ? 16U : 17U); ++y) {
        const std::uint32_t bits = block ? block->solid[(z & 15) * 16 + (y & 15)] : uniform;
        rows[z][y] |= (bits & keep) << (16 * dx);
      }
    }
  }
}

std::array<std::uint16_t, 16> Cells::inside_rows(const Index& b) const {
  std::array<std::uint16_t, 16> rows{};
  for (int y = 0; y < 16; ++y) {
    unsigned bits = 0;
    for (int x = 0; x < 16; ++x) {
      bits |= (volume_.meshed(16 * b[0] + x, 16 * b[1] + y) ? 1U : 0U) << x;
    }
    rows[static_cast<std::size_t>(y)] = static_cast<std::uint16_t>(bits);
  }
  return rows;
}

void Cells::add_group(const Index& b) {
  Rows rows{};
  read_rows(b, rows);
  const auto inside = inside_rows(b);
  auto group = std::make_unique<Group>();
  for (std::size_t r = 0; r < 256; ++r) {
    const std::size_t y = r & 15, z = r >> 4;
    const std::int64_t k = 16 * b[2] + static_cast<int>(z);
    group->first[r] = static_cast<std::uint16_t>(group->cells.size());
    if (k < volume_.low()[2] || k >= volume_.high()[2]) continue;
    const auto r00 = rows[z][y], r10 = rows[z][y + 1], r01 = rows[z + 1][y],
               r11 = rows[z + 1][y + 1];
    const auto any = r00 | r10 | r01 | r11, all = r00 & r10 & r01 & r11;
    unsigned active = (any | any >> 1) & ~(all & all >> 1) & inside[y];
    group->active[r] = static_cast<std::uint16_t>(active);
    for (; active != 0; active &= active - 1) {
      const int x = std::countr_zero(active);
      const unsigned mask =
          (r00 >> x & 3) | (r10 >> x & 3) << 2 | (r01 >> x & 3) << 4 | (r11 >> x & 3) << 6;
      add_cell({16 * b[0] + x, 16 * b[1] + static_cast<int>(y), k}, mask, *group);
    }
  }
  if (!group->cells.empty()) groups_[group_of(b)] = std::move(group);
}

void Cells::add_cell(const Index& cell, unsigned mask, Group& group) {
  const bool flipped = is_flipped(cell, mask);
  group.cells.push_back(
      {static_cast<std::uint32_t>(out_.points.size()), static_cast<std::uint8_t>(mask), flipped});
  add_sheets(cell, case_of(mask, flipped));
}

void Cells::add_sheets(const Index& cell, const Case& sheets) {
  std::array<std::array<std::int32_t, 3>, 4> taken;
  for (std::size_t sheet = 0; sheet < static_cast<std::size_t>(sheets.sheets); ++sheet) {
    std::array<Plane3, 12> planes;
    std::size_t count = 0;
    for (unsigned edges = sheets.edges[sheet]; edges != 0; edges &= edges - 1) {
      const auto edge = static_cast<unsigned>(std::countr_zero(edges));
      const std::size_t a = edge / 4;
      Index low = cell;
      low[next_axis(a)] += edge & 1;
      low[last_axis(a)] += edge >> 1 & 1;
      const auto axis = static_cast<int>(a);
      const auto& crossing = volume_.crossing(axis, low);
      Vec3 point{static_cast<double>(low[0] - cell[0]), static_cast<double>(low[1] - cell[1]),
                 static_cast<double>(low[2] - cell[2])};
      point[axis] = static_cast<double>(crossing.t);
      planes[count++] = {point, {crossing.normal.x, crossing.normal.y, crossing.normal.z}};
    }
    const std::span<const Plane3> used(planes.data(), count);
    const Vec3 mean = mean_point(used);
    const Vec3 best = mean + minimise(used, mean);
    taken[sheet] = free_point<3>({snap(best.x, units_), snap(best.y, units_), snap(best.z, units_)},
                                 std::span(taken).first(sheet), {mean.x, mean.y, mean.z}, units_);
    auto point = taken[sheet];
    for (std::size_t d = 0; d < 3; ++d) {
      point[d] += static_cast<std::int32_t>(cell[d] - volume_.low()[d]) * units_;
    }
    out_.points.push_back(point);
    out_.planes.push_back(0);
  }
}

unsigned Cells::mask_of(const Index& cell) const {
  unsigned mask = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Index p{cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2)};
    mask |= (volume_.solid(p) ? 1U : 0U) << corner;
  }
  return mask;
}

/// A face between two cells of the surface that is bad in both is flipped in both: otherwise two
/// dual edges would join the same two vertices. Faces on a border are never flipped, since what
/// lies beyond is not known.
bool Cells::is_flipped(const Index& cell, unsigned mask) const {
  const int face = base_[mask].bad_face;
  if (face < 0) return false;
  Index beyond = cell;
  beyond[static_cast<std::size_t>(face / 2)] += face % 2 == 1 ? 1 : -1;
  return inside(beyond) && base_[mask_of(beyond)].bad_face == (face ^ 1);
}

}  // namespace hoodoo::surface
