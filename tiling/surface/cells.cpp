#include "tiling/surface/cells.hpp"

#include <algorithm>

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
  place_sheets();
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

void Cells::add_group(const Index& b) {
  volume::Volume::Rows rows;
  volume_.read_rows(b, rows);
  const auto& meshed = volume_.meshed_rows(b[0], b[1]);
  const auto& high = volume_.block_high();
  Owners owners{};
  for (std::size_t part = 0; part < 8; ++part) {
    const Index at{b[0] + static_cast<int>(part & 1), b[1] + static_cast<int>(part >> 1 & 1),
                   b[2] + static_cast<int>(part >> 2)};
    const bool covered = at[0] < high[0] && at[1] < high[1] && at[2] < high[2];
    if (covered) owners[part] = volume_.block(at);
  }
  auto group = std::make_unique<Group>();
  for (std::size_t r = 0; r < 256; ++r) {
    const std::size_t y = r & 15, z = r >> 4;
    const std::int64_t k = 16 * b[2] + static_cast<int>(z);
    group->first[r] = static_cast<std::uint16_t>(group->cells.size());
    if (k < volume_.low()[2] || k >= volume_.high()[2]) continue;
    const auto r00 = rows[z][y], r10 = rows[z][y + 1], r01 = rows[z + 1][y],
               r11 = rows[z + 1][y + 1];
    const auto any = r00 | r10 | r01 | r11, all = r00 & r10 & r01 & r11;
    unsigned active = (any | any >> 1) & ~(all & all >> 1) & meshed[y + 1] >> 1 & 0xffffU;
    group->active[r] = static_cast<std::uint16_t>(active);
    for (; active != 0; active &= active - 1) {
      const int x = std::countr_zero(active);
      const unsigned mask =
          (r00 >> x & 3) | (r10 >> x & 3) << 2 | (r01 >> x & 3) << 4 | (r11 >> x & 3) << 6;
      add_cell({16 * b[0] + x, 16 * b[1] + static_cast<int>(y), k}, mask, owners, *group);
    }
  }
  if (!group->cells.empty()) groups_[group_of(b)] = std::move(group);
}

void Cells::add_cell(const Index& cell, unsigned mask, const Owners& owners, Group& group) {
  const bool flipped = is_flipped(cell, mask);
  const Case& sheets = case_of(mask, flipped);
  const auto count = static_cast<std::size_t>(sheets.sheets);
  if (waiting_count_ + count > SheetLanes::most) place_sheets();
  group.cells.push_back({static_cast<std::uint32_t>(out_.points.size() + waiting_count_),
                         static_cast<std::uint8_t>(mask), flipped});
  for (std::size_t sheet = 0; sheet < count; ++sheet) {
    waiting_[waiting_count_] = {cell, sheet == 0};
    add_sheet(cell, sheets.edges[sheet], owners);
  }
}

/// Puts the planes at the crossings of `edges` into the next lane.
void Cells::add_sheet(const Index& cell, unsigned edges, const Owners& owners) {
  const std::size_t lane = waiting_count_++;
  std::size_t count = 0;
  for (; edges != 0; edges &= edges - 1, ++count) {
    const auto edge = static_cast<unsigned>(std::countr_zero(edges));
    const std::size_t a = edge / 4;
    std::array<unsigned, 3> offset{};
    offset[next_axis(a)] = edge & 1;
    offset[last_axis(a)] = edge >> 1 & 1;
    std::array<unsigned, 3> at{};  // the edge's low end, from the low corner of the group's block
    unsigned owner = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      at[d] = static_cast<unsigned>(cell[d] & 15) + offset[d];
      owner |= at[d] >> 4 << d;
    }
    const auto& crossing = owners[owner]->crossing(a, (at[2] & 15) * 16 + (at[1] & 15), at[0] & 15);
    for (std::size_t d = 0; d < 3; ++d) {
      lanes_.point[count][d][lane] = static_cast<float>(offset[d]);
    }
    lanes_.point[count][a][lane] = crossing.t;
    lanes_.normal[count][0][lane] = crossing.normal.x;
    lanes_.normal[count][1][lane] = crossing.normal.y;
    lanes_.normal[count][2][lane] = crossing.normal.z;
  }
  lanes_.count[lane] = static_cast<double>(count);
}

void Cells::place_sheets() {
  solve(lanes_, waiting_count_, units_);
  std::array<std::array<std::int32_t, 3>, 4> taken;
  std::size_t taken_count = 0;
  for (std::size_t i = 0; i < waiting_count_; ++i) {
    const auto& [cell, first] = waiting_[i];
    if (first) taken_count = 0;
    std::array<std::int32_t, 3> point{lanes_.steps[0][i], lanes_.steps[1][i], lanes_.steps[2][i]};
    if (taken_count > 0) {
      point = free_point<3>(point, std::span(taken).first(taken_count),
                            {lanes_.mean[0][i], lanes_.mean[1][i], lanes_.mean[2][i]}, units_);
    }
    taken[taken_count++] = point;
    for (std::size_t d = 0; d < 3; ++d) {
      point[d] += static_cast<std::int32_t>(cell[d] - volume_.low()[d]) * units_;
    }
    out_.points.push_back(point);
    out_.planes.push_back(0);
  }
  waiting_count_ = 0;
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
