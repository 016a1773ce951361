#include <gtest/gtest.h>

#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

TEST(Slope, BesideAHoleCountsItAsLevel) {
  const Grid grid = grid_of(3, {0, 4, 8, 0, 4, hole, 0, 4, 8}, 2);
  const auto s = slope(grid);
  // West-east weights 1 2 1 over 8 cells of 2 m: the middle one of the east counts 4.
  EXPECT_FLOAT_EQ(s[4], (8 + 2 * 4 + 8 - 0) / 16.0F);
  EXPECT_TRUE(std::isnan(s[5]));
}

TEST(Slope, UsesTheSizeOfEachRow) {
  Grid grid = grid_of(3, {0, 1, 2, 0, 1, 2, 0, 1, 2});
  grid.dx = {1, 4, 1};
  EXPECT_FLOAT_EQ(slope(grid)[4], 0.25F);
}

TEST(Sinks, HaveTheDepthAndAreaOfTheirDepression) {
  const Grid grid = grid_of(7, {9, 9, 9, 9, 9, 9, 9,  //
                                9, 5, 6, 5, 9, 7, 9,  //
                                9, 5, 6, 4, 9, 9, 9,  //
                                9, 6, 6, 6, 8, 9, 8,  //
                                9, 9, 9, 9, 9, 9, 9},
                            2);
  Grid filled = grid;
  fill(filled);
  const auto found = sinks(grid, filled);
  ASSERT_EQ(found.size(), 3U);
  // Level ground of two cells, then the pit beside it: one depression of nine, spilling at 8.
  EXPECT_EQ(found[0].i, 1);
  EXPECT_EQ(found[0].j, 1);
  EXPECT_EQ(found[0].depth, 4) << "9 all around but for the way over 8, which 9 closes";
  EXPECT_EQ(found[1].i, 5);
  EXPECT_EQ(found[1].depth, 2);
  EXPECT_EQ(found[1].area, 4);
  EXPECT_EQ(found[2].elevation, 4);
  EXPECT_EQ(found[2].depth, 5);
  EXPECT_EQ(found[2].area, found[0].area);
}

TEST(Sinks, AreNotAtTheEdgeNorBesideAHole) {
  const Grid grid = grid_of(5, {1, 9, 9, 9,    9,  //
                                9, 9, 9, 9,    9,  //
                                9, 9, 2, hole, 9,  //
                                9, 9, 9, 9,    9,  //
                                9, 9, 9, 9,    9});
  Grid filled = grid;
  fill(filled);
  EXPECT_TRUE(sinks(grid, filled).empty());
}

}  // namespace
}  // namespace hoodoo::hydrology
