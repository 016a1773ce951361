#include <gtest/gtest.h>

#include <algorithm>

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

/// Connected cells from `first` on that satisfy `is_part`.
template <class IsPart>
std::vector<std::size_t> flood(const Grid& grid, std::size_t first, IsPart is_part) {
  const Neighbours neighbours(grid);
  std::vector<std::size_t> cells{first};
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const unsigned inside = neighbours.inside(cells[n]);
    for (unsigned k = 0; k < 8; ++k) {
      if ((inside >> k & 1) == 0) continue;
      const auto next = neighbours.at(cells[n], k);
      if (is_part(next) && std::ranges::find(cells, next) == cells.end()) cells.push_back(next);
    }
  }
  return cells;
}

TEST(Sinks, AreThoseThatFloodsFindOneByOne) {
  std::size_t number = 0;
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    const Grid grid = rough(seed, 23, 17, seed % 2 == 0 ? 4 : 9, seed % 3 == 0 ? 0.02 : 0);
    Grid filled = grid;
    fill(filled);
    const Neighbours neighbours(grid);
    std::vector<Sink> expected;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      if (!grid.valid(cell)) continue;
      const auto level = flood(grid, cell, [&](auto c) { return grid.z[c] == grid.z[cell]; });
      const bool first = *std::ranges::min_element(level) == cell;
      const bool closed = std::ranges::all_of(level, [&](std::size_t c) {
        for (unsigned k = 0; k < 8; ++k) {
          if (neighbours.valid(c) != 0xff || grid.z[neighbours.at(c, k)] < grid.z[c]) return false;
        }
        return true;
      });
      if (!first || !closed) continue;
      const auto water = flood(grid, cell, [&](auto c) { return filled.z[c] > grid.z[c]; });
      expected.push_back({static_cast<std::int32_t>(cell % 23),
                          static_cast<std::int32_t>(cell / 23), grid.z[cell],
                          static_cast<double>(filled.z[cell] - grid.z[cell]),
                          static_cast<double>(water.size()) * grid.area(0)});
    }
    EXPECT_EQ(sinks(grid, filled), expected) << seed;
    number += expected.size();
  }
  EXPECT_GT(number, 100U);
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
