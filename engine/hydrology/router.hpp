#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {

/// Steps of a cell to the outlet of the flat it lies on: 0 where there is lower ground beside it,
/// or water leaves; `far_away` while no way is known.
inline constexpr std::uint32_t far_away = std::numeric_limits<std::uint32_t>::max();

/// Receivers of some rows of a grid: each step sees one row beyond them, as far as the grid goes. A
/// raster whose parts lie in several grids gives the same as in one, once no part's `cross`
/// changes its steps any more.
class Router {
 public:
  Router(const Grid& grid, Rows rows, Routing routing)
      : grid_(grid), rows_(rows), routing_(routing), neighbours_(grid) {}

  /// Where there is lower ground; the steps of all cells, before flats are crossed.
  void descend(std::span<std::uint8_t> receivers, std::span<std::uint32_t> steps);
  /// Steps of the rows' flats, no greater than before, by those of the rows beyond them.
  void cross(std::span<std::uint32_t> steps);
  /// Receivers on flats.
  void choose_on_flats(std::span<std::uint8_t> receivers, std::span<const std::uint32_t> steps);

 private:
  void descend_row(std::int32_t j, std::uint8_t* lower) const;
  unsigned lower_by_one(std::size_t cell) const;
  std::uint8_t chosen(std::size_t cell, unsigned candidates) const;
  unsigned steepest(std::size_t cell, unsigned candidates) const;
  std::size_t begin() const { return grid_.index(0, rows_.from); }
  std::size_t end() const { return grid_.index(0, rows_.to); }

  const Grid& grid_;
  Rows rows_;
  Routing routing_;
  Neighbours neighbours_;
};

}  // namespace hoodoo::hydrology
