#pragma once
#include <array>
#include <memory>

#include "engine/tree/field.hpp"

namespace hoodoo::slice {

/// What closes the world within one block of 16^3 cells.
struct Closure {
  double spacing;  // [m]
  double floor;    // z, relative to the block [m]: air below
  /// Of the lattice points of the block's closed square, [j][i]: all four columns of cells
  /// around it lie in the world.
  std::array<std::array<bool, 17>, 17> inside;

  /// It changes nothing in the block.
  bool is_open() const;
};

/// min(F, W, B) of a compiled field. W falls from 1 at lattice points inside the world to just
/// below 1/2 at the others, bilinear in x and y, so that a wall stands within a 250th of a cell of
/// the cells that are meshed, on their side; B = 1/2 + (z - floor) / (2 spacing), in [0, 1].
std::unique_ptr<const tree::Field> closed(std::unique_ptr<const tree::Field> field,
                                          const Closure& closure);

}  // namespace hoodoo::slice
