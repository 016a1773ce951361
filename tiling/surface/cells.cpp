#include "tiling/surface/cells.hpp"

#include <algorithm>
#include <bit>

#include "tiling/surface/snap.hpp"

namespace hoodoo::surface {

using volume::Index;

Cells::Cells(const volume::Volume& volume, int units, Workspace& workspace)
    : volume_(volume), units_(units), out_(workspace.surface), pool_(workspace.groups) {
  const auto& low = volume.block_low();
  const auto& high = volume.block_high();
  groups_.resize(group_of({high[0] - 1, high[1] - 1, high[2] - 1}) + 1);
  std::size_t crossings = 0;  // somewhat more than there will be vertices
  for (std::int64_t z = low[2]; z < high[2]; ++z) {
    for (std::int64_t y = low[1]; y < high[1]; ++y) {
      for (std::int64_t x = low[0]; x < high[0]; ++x) {
        if (const auto* block = volume.block({x, y, z})) crossings += block->crossings.size();
      }
    }
  }
  out_.points.reserve(crossings + 1);
  for (std::int64_t z = low[2]; z < high[2]; ++z) {
    for (std::int64_t y = low[1]; y < high[1]; ++y) {
      for (std::int64_t x = low[0]; x < high[0]; ++x) {
        if (may_hold_surface({x, y, z})) add_group({x, y, z});
      }
    }
  }
  place_sheets();
  out_.points.resize(made_);
  out_.planes.resize(made_);
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

Cells::Owners Cells::owners_around(const Index& b) const {
  Owners owners{};
  const auto& high = volume_.block_high();
  for (std::size_t part = 0; part < 8; ++part) {
    const Index at{b[0] + static_cast<int>(part & 1), b[1] + static_cast<int>(part >> 1 & 1),
                   b[2] + static_cast<int>(part >> 2)};
    const bool covered = at[0] < high[0] && at[1] < high[1] && at[2] < high[2];
    if (covered) owners[part] = volume_.block(at);
  }
  return owners;
}

namespace {

/// The edges along `axis` from the points of one row; the first beyond them where `beyond`.
CellRow::Edges edges_of(const volume::Block* own, const volume::Block* next, std::size_t axis,
                        std::size_t row, bool beyond) {
  CellRow::Edges edges{};
  if (own != nullptr) {
    edges.crossed = own->crossed[axis][row];
    edges.own = own->crossings.data() + own->first[axis][row];
  }
  if (beyond && next != nullptr) edges.next = next->crossings.data() + next->first[axis][row];
  return edges;
}

/// The places beside a row of cells where edges of each axis begin.
constexpr std::array<std::array<std::size_t, 2>, 8> edge_rows{
    {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}};

}  // namespace

void Cells::add_group(const Index& b) {
  volume::Volume::Rows rows;
  volume_.read_rows(b, rows);
  const auto& meshed = volume_.meshed_rows(b[0], b[1]);
  const Owners owners = owners_around(b);
  std::array<std::uint16_t, 256> active_rows;
  find_active(rows, meshed, active_rows);
  CellGroup* group = nullptr;
  // Layers of the box.
  const auto layer = [&](std::int64_t z) { return std::clamp<std::int64_t>(z - 16 * b[2], 0, 16); };
  const auto from = static_cast<std::size_t>(16 * layer(volume_.low()[2]));
  const auto to = static_cast<std::size_t>(16 * layer(volume_.high()[2]));
  for (std::size_t r = from; r < to; ++r) {
    const unsigned active = active_rows[r];
    if (active == 0) continue;
    const std::size_t y = r & 15, z = r >> 4;
    const Index first{16 * b[0], 16 * b[1] + static_cast<int>(y), 16 * b[2] + static_cast<int>(z)};
    CellRow row;
    row.solid = {rows[z][y], rows[z][y + 1], rows[z + 1][y], rows[z + 1][y + 1]};
    for (const auto& [axis, beside] : edge_rows) {
      const std::size_t j = y + (beside & 1), k = z + (beside >> 1);
      const std::size_t owner = (j >> 4) * 2 + (k >> 4) * 4, at = (k & 15) * 16 + (j & 15);
      row.edges[axis][beside] =
          edges_of(owners[owner], owners[owner + 1], axis, at, (active >> 15) != 0);
    }
    if (group == nullptr) {
      if (used_ == pool_.size()) pool_.push_back(std::make_unique_for_overwrite<CellGroup>());
      group = groups_[group_of(b)] = pool_[used_++].get();
    }
    for (std::size_t d = 0; d < 3; ++d) {
      row.corner[d] = static_cast<std::int32_t>(first[d] - volume_.low()[d]) * units_;
    }
    add_row(first, row, active, *group);
  }
}

void Cells::add_row(const Index& first, const CellRow& row, unsigned active, CellGroup& group) {
  constexpr std::size_t most = 16 * 4, ahead = 4096;  // vertices of a row; room made at once
  if (out_.points.size() < made_ + most) out_.points.resize(made_ + ahead);
  const unsigned flat = active & row.flat();
  std::array<Point, 16> points;
  if (flat != 0) solve_flat(row, flat, units_, points);
  std::uint32_t* vertices = group.vertex.data() + place_of(first);
  while (active != 0) {
    for (unsigned low; (low = active & (0U - active) & flat) != 0; active ^= low) {
      const auto x = static_cast<std::size_t>(std::countr_zero(low));
      out_.points[made_] = points[x];
      vertices[x] = made_++;
    }
    const unsigned next = active & flat, run = active & ((next & (0U - next)) - 1);
    if (run == 0) continue;
    const std::size_t before = waiting_;
    const unsigned left = gather(row, run, units_, lanes_, waiting_, made_, vertices);
    made_ += static_cast<std::uint32_t>(waiting_ - before);
    active ^= run ^ left;
    if (waiting_ == SheetLanes::most) {
      place_sheets();
    } else if (left != 0) {
      add_cell({first[0] + std::countr_zero(left), first[1], first[2]}, row, group);
      active &= active - 1;
    }
  }
}

/// A cell of several sheets, perhaps.
void Cells::add_cell(const Index& cell, const CellRow& row, CellGroup& group) {
  const auto x = static_cast<unsigned>(cell[0] & 15);
  const unsigned mask = row.mask(x);
  const bool flipped = is_flipped(cell, mask);
  const Case& sheets = case_of(mask, flipped);
  const auto count = static_cast<std::size_t>(sheets.sheets);
  if (waiting_ + count > SheetLanes::most) place_sheets();
  auto& vertex = group.vertex[place_of(cell)];
  vertex = made_;
  if (count > 1) {
    vertex |= CellGroup::several | (flipped ? CellGroup::flipped : 0);
    group.mask[place_of(cell)] = static_cast<std::uint8_t>(mask);
  }
  for (std::size_t sheet = 0; sheet < count; ++sheet, ++waiting_) {
    gather(row, x, sheets.edges[sheet], units_, lanes_, waiting_);
    lanes_.number[waiting_] = made_++;
    if (sheet > 0) lanes_.further |= std::uint64_t{1} << waiting_;
  }
}

void Cells::place_sheets() {
  if (waiting_ == 0) return;
  solve(lanes_, waiting_, units_);
  for (auto further = lanes_.further; further != 0; further &= further - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(further));
    std::size_t first = i;
    while ((lanes_.further >> first & 1) != 0) --first;
    lanes_.point[i] =
        free_point<3>(lanes_.point[i], std::span(lanes_.point + first, i - first),
                      {lanes_.mean[0][i], lanes_.mean[1][i], lanes_.mean[2][i]}, units_);
  }
  for (std::size_t i = 0; i < waiting_; ++i) {
    for (std::size_t d = 0; d < 3; ++d) lanes_.point[i][d] += lanes_.corner[d][i];
    out_.points[lanes_.number[i]] = lanes_.point[i];
  }
  lanes_.further = 0;
  waiting_ = 0;
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
