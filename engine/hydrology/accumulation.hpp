#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "engine/hydrology/distance.hpp"
#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::hydrology {

/// Areas of some rows of a grid by their donors, each summed in the order of neighbours once all of
/// them are known. It sees one row beyond its rows, as far as the grid goes: so a raster whose
/// parts lie in several grids gives the same as in one, once no part settles anything any more.
class Accumulation {
 public:
  /// By cell of the grid. `per_weight` is the area over the weights of all receivers [m^2], the
  /// area itself where there are none; 0 while that is not known.
  struct Cells {
    std::span<const std::uint8_t> receivers;
    std::span<double> per_weight;
    std::span<float> area;
  };

  Accumulation(const Grid& grid, Rows rows, double exponent);

  /// Settles each cell all of whose donors are settled, over and over; returns how many.
  std::size_t settle(const Cells& cells);

 private:
  void find_donors();
  void settle_from(std::size_t first);
  void settle_cell(std::size_t cell);
  double weight(std::size_t cell, unsigned k) const;
  double all_weights(std::size_t cell) const;
  const Distances& distances(std::size_t cell) const;

  const Grid& grid_;
  Rows rows_;
  double exponent_;
  Neighbours neighbours_;
  std::vector<Distances> distances_;  // by row; one where all rows have the same size
  Cells cells_;
  std::vector<std::uint8_t> donors_;   // neighbours whose water comes here, one bit each
  std::vector<std::uint8_t> missing_;  // of those, the ones that are not settled yet
  std::vector<std::uint32_t> ready_;
  std::size_t settled_ = 0;
};

}  // namespace hoodoo::hydrology
