#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "tiling/surface/lanes.hpp"
#include "tiling/surface/surface.hpp"
#include "tiling/surface/tables.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::surface {

/// 16^3 cells, anchored like the blocks of points: cell (x, y, z) at 256 z + 16 y + x.
struct CellGroup {
  static constexpr std::uint32_t several = 1U << 31, flipped = 1U << 30, number = flipped - 1;
  std::array<std::uint32_t, 4096> vertex;  // of cells that the surface passes: the first one, and
                                           // whether there are several and the cell is flipped
  std::array<std::uint8_t, 4096> mask;     // of those with several
};

/// The meshed cells that the surface passes, and their vertices: one per sheet, appended to a
/// surface block by block.
class Cells {
 public:
  Cells(const volume::Volume& volume, int units, Workspace& workspace);

  /// The cell is part of this surface.
  bool inside(const volume::Index& cell) const {
    return cell[2] >= volume_.low()[2] && cell[2] < volume_.high()[2] &&
           volume_.meshed(cell[0], cell[1]);
  }

  /// Null where no cell can be passed.
  const CellGroup* group(const volume::Index& b) const { return groups_[group_of(b)]; }

  /// The vertex of the sheet that holds `edge` of the cell at `place` of `group`; the edge is
  /// crossed, the cell inside.
  std::uint32_t vertex(const CellGroup& group, std::size_t place, unsigned edge) const {
    const std::uint32_t v = group.vertex[place];
    if ((v & CellGroup::several) == 0) return v;
    const Case& sheets = case_of(group.mask[place], (v & CellGroup::flipped) != 0);
    return (v & CellGroup::number) + static_cast<std::uint32_t>(sheets.sheet[edge]);
  }
  std::uint32_t vertex(const volume::Index& cell, unsigned edge) const {
    return vertex(*group({cell[0] >> 4, cell[1] >> 4, cell[2] >> 4}), place_of(cell), edge);
  }

 private:
  /// The blocks that own the edges of a group's cells: its own and those beyond it, null where not
  /// stored. Bit a of an index: beyond along axis a.
  using Owners = std::array<const volume::Block*, 8>;

  static std::size_t place_of(const volume::Index& cell) {
    return static_cast<std::size_t>((cell[2] & 15) * 256 + (cell[1] & 15) * 16 + (cell[0] & 15));
  }
  const Case& case_of(unsigned mask, bool flipped) const {
    return flipped ? flipped_[mask] : base_[mask];
  }
  std::size_t group_of(const volume::Index& b) const;
  bool may_hold_surface(const volume::Index& b) const;
  Owners owners_around(const volume::Index& b) const;
  void add_group(const volume::Index& b);
  void add_row(const volume::Index& first, const CellRow& row, unsigned active, CellGroup& group);
  void add_cell(const volume::Index& cell, const CellRow& row, CellGroup& group);
  void place_sheets();
  unsigned mask_of(const volume::Index& cell) const;
  bool is_flipped(const volume::Index& cell, unsigned mask) const;

  const volume::Volume& volume_;
  const int units_;
  Surface& out_;
  const std::array<Case, 256>& base_ = cases();
  const std::array<Case, 256>& flipped_ = flipped_cases();
  std::vector<std::unique_ptr<CellGroup>>& pool_;
  std::size_t used_ = 0;  // of the pool
  std::vector<CellGroup*> groups_;
  // Sheets that wait for their vertices: all those of a cell together.
  SheetLanes lanes_;
  std::size_t waiting_ = 0;
  std::uint32_t made_ = 0;  // vertices, with those that wait
};

}  // namespace hoodoo::surface
