#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "tiling/surface/lanes.hpp"
#include "tiling/surface/surface.hpp"
#include "tiling/surface/tables.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::surface {

/// The meshed cells that the surface passes, and their vertices: one per sheet, appended to a
/// surface block by block.
class Cells {
 public:
  Cells(const volume::Volume& volume, int units, Surface& out);

  /// The cell is part of this surface.
  bool inside(const volume::Index& cell) const {
    return cell[2] >= volume_.low()[2] && cell[2] < volume_.high()[2] &&
           volume_.meshed(cell[0], cell[1]);
  }
  /// The vertex of the sheet that holds `edge` of `cell`; the edge is crossed, the cell inside.
  std::uint32_t vertex(const volume::Index& cell, unsigned edge) const {
    return vertex(*group({cell[0] >> 4, cell[1] >> 4, cell[2] >> 4}), cell, edge);
  }

  struct Cell {
    std::uint32_t first_vertex;
    std::uint8_t mask;
    bool flipped;
  };
  /// 16^3 cells, anchored like the blocks of points.
  struct Group {
    std::array<std::uint16_t, 256> active{};  // one bit per cell, row = 16 z + y
    std::array<std::uint16_t, 256> first{};   // active cells before the row
    std::vector<Cell> cells;
  };
  /// Null where no cell is active.
  const Group* group(const volume::Index& b) const { return groups_[group_of(b)].get(); }
  /// As above, for a cell of `group`.
  std::uint32_t vertex(const Group& group, const volume::Index& cell, unsigned edge) const {
    const auto row = static_cast<std::size_t>((cell[2] & 15) * 16 + (cell[1] & 15));
    const unsigned before = group.active[row] & ((1U << (cell[0] & 15)) - 1);
    const Cell& c = group.cells[group.first[row] + volume::count_bits(before)];
    return c.first_vertex + static_cast<std::uint32_t>(case_of(c.mask, c.flipped).sheet[edge]);
  }

 private:
  /// The blocks that own the edges of a group's cells: its own and those beyond it, null where not
  /// stored. Bit a of an index: beyond along axis a.
  using Owners = std::array<const volume::Block*, 8>;

  const Case& case_of(unsigned mask, bool flipped) const {
    return flipped ? flipped_[mask] : base_[mask];
  }
  std::size_t group_of(const volume::Index& b) const;
  bool may_hold_surface(const volume::Index& b) const;
  void add_group(const volume::Index& b);
  void add_cell(const volume::Index& cell, unsigned mask, const Owners& owners, Group& group);
  void add_sheet(const volume::Index& cell, unsigned edges, const Owners& owners);
  void place_sheets();
  unsigned mask_of(const volume::Index& cell) const;
  bool is_flipped(const volume::Index& cell, unsigned mask) const;

  const volume::Volume& volume_;
  const int units_;
  Surface& out_;
  const std::array<Case, 256>& base_ = cases();
  const std::array<Case, 256>& flipped_ = flipped_cases();
  std::vector<std::unique_ptr<Group>> groups_;
  // Sheets that wait for their vertices: all those of a cell together.
  SheetLanes lanes_;
  struct Waiting {
    volume::Index cell;
    bool first;  // of its cell
  };
  std::array<Waiting, SheetLanes::most> waiting_;
  std::size_t waiting_count_ = 0;
};

}  // namespace hoodoo::surface
