#include <gtest/gtest.h>

#include <queue>

#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

/// Levels by relaxation: over and over, no cell higher than the lowest neighbour's level allows.
Grid filled_slowly(const Grid& grid) {
  Grid level = grid;
  const Neighbours neighbours(grid);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    const bool leaves = neighbours.valid(c) != 0xff;
    if (grid.valid(c) && !leaves) level.z[c] = std::numeric_limits<float>::max();
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t c = 0; c < grid.size(); ++c) {
      if (!grid.valid(c) || neighbours.valid(c) != 0xff) continue;
      float lowest = std::numeric_limits<float>::max();
      for (unsigned k = 0; k < 8; ++k) lowest = std::min(lowest, level.z[neighbours.at(c, k)]);
      const float z = std::max(grid.z[c], lowest);
      changed = changed || z < level.z[c];
      level.z[c] = std::min(z, level.z[c]);
    }
  }
  return level;
}

void expect_same(const Grid& a, const Grid& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t c = 0; c < a.size(); ++c) {
    if (std::isnan(a.z[c]) && std::isnan(b.z[c])) continue;
    ASSERT_EQ(a.z[c], b.z[c]) << "cell " << c;
  }
}

TEST(Fill, RaisesAPitToWhereItSpills) {
  Grid grid = grid_of(5, {9, 9, 9, 9, 9,  //
                          9, 1, 2, 9, 9,  //
                          9, 2, 0, 3, 5,  //
                          9, 9, 9, 9, 9,  //
                          9, 9, 9, 9, 9});
  fill(grid);
  EXPECT_EQ(grid.z, (std::vector<float>{9, 9, 9, 9, 9,  //
                                        9, 5, 5, 9, 9,  //
                                        9, 5, 5, 5, 5,  //
                                        9, 9, 9, 9, 9,  //
                                        9, 9, 9, 9, 9}));
}

TEST(Fill, LeavesWhatDrainsIntoAHole) {
  Grid grid = grid_of(4, {9, 9, 9, 9,     //
                          9, 2, hole, 9,  //
                          9, 3, 4, 9,     //
                          9, 9, 9, 9});
  const Grid before = grid;
  fill(grid);
  expect_same(grid, before);
}

TEST(Fill, GivesWhatRelaxationGivesOnRandomGround) {
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    Grid grid = rough(seed, 17 + static_cast<std::int32_t>(seed % 9), 23, seed % 2 == 0 ? 6 : 1000,
                      seed % 3 == 0 ? 0.05 : 0);
    const Grid expected = filled_slowly(grid);
    fill(grid);
    expect_same(grid, expected);
  }
}

TEST(Fill, HasNoWorkOnARasterOfOneRow) {
  Grid grid = grid_of(4, {3, 1, 2, 0});
  const Grid before = grid;
  fill(grid);
  expect_same(grid, before);
}

}  // namespace
}  // namespace hoodoo::hydrology
