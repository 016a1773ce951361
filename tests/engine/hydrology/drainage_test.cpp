#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

constexpr unsigned bit(unsigned k) { return 1U << k; }

double total_area(const Grid& grid) {
  double area = 0;
  for (std::int32_t j = 0; j < grid.height; ++j) {
    for (std::int32_t i = 0; i < grid.width; ++i) {
      if (grid.valid(grid.index(i, j))) area += grid.area(j);
    }
  }
  return area;
}

/// A plane that falls by 1 with every column and 2 with every row; 3 m cells.
Grid plane(std::int32_t side) {
  std::vector<float> z;
  for (std::int32_t j = 0; j < side; ++j) {
    for (std::int32_t i = 0; i < side; ++i) z.push_back(static_cast<float>(1000 - i - 2 * j));
  }
  return grid_of(side, std::move(z), 3);
}

TEST(Receivers, AreAllLowerNeighboursOrTheSteepest) {
  const Grid grid = plane(5);
  const auto all = receivers(grid, Routing::freeman), one = receivers(grid, Routing::d8);
  // East, and the three of the next row; north-east rises by 1.
  EXPECT_EQ(all[grid.index(2, 2)], bit(0) | bit(5) | bit(6) | bit(7));
  // 3 / sqrt 2 beats 2 and 1.
  EXPECT_EQ(one[grid.index(2, 2)], bit(7));
  EXPECT_EQ(all[grid.index(4, 4)], 0) << "water leaves at the lowest corner";
}

TEST(Receivers, LeadOverAFlatToItsOutletByTheFewestSteps) {
  Grid grid = grid_of(7, {9, 9, 9, 9, 9, 9, 9,  //
                          9, 5, 5, 5, 5, 5, 9,  //
                          9, 5, 5, 5, 5, 5, 4,  //
                          9, 5, 5, 5, 5, 5, 9,  //
                          9, 9, 9, 9, 9, 9, 9});
  const auto to = receivers(grid, Routing::freeman);
  EXPECT_EQ(to[grid.index(5, 2)], bit(0)) << "it has lower ground beside it";
  EXPECT_EQ(to[grid.index(5, 1)], bit(7)) << "it has, too";
  EXPECT_EQ(to[grid.index(4, 2)], bit(1) | bit(0) | bit(7));
  EXPECT_EQ(to[grid.index(1, 2)], bit(1) | bit(0) | bit(7));
  EXPECT_EQ(receivers(grid, Routing::d8)[grid.index(1, 2)], bit(0)) << "the nearest of the three";
}

TEST(Receivers, OfAPitAreNone) {
  const Grid grid = grid_of(3, {9, 9, 9, 9, 1, 9, 9, 9, 9});
  EXPECT_EQ(receivers(grid, Routing::freeman)[4], 0);
}

TEST(Area, SharesByThePowerOfSlopes) {
  // One high cell over a ring: along rows and columns it falls by 2, across by 1.
  const Grid grid = grid_of(3, {9, 8, 9, 8, 10, 8, 9, 8, 9}, 10);
  const auto drainage = accumulate(grid, receivers(grid, Routing::freeman));
  const double straight = std::pow(2.0 / 10, 1.1),
               across = std::pow(1 / (10 * std::sqrt(2.0)), 1.1);
  const double share = straight / (4 * (straight + across));
  // Each side's middle also gets half of both corners beside it.
  const double corner = 100 + 100 * across / (4 * (straight + across));
  EXPECT_NEAR(static_cast<double>(drainage.area[1]), 100 + 100 * share + corner, 1e-4);
  EXPECT_FLOAT_EQ(drainage.area[4], 100);
}

TEST(Area, OfAnyExponentSharesAsThatSays) {
  const Grid grid = grid_of(3, {hole, hole, hole, hole, 7, hole, hole, 4, 6.5F});
  for (const double p : {0.5, 1.0, 1.1, 1.1000001, 3.0}) {
    const auto drainage = accumulate(grid, receivers(grid, Routing::freeman), p);
    const double down = std::pow(3.0, p), aside = std::pow(0.5 / std::sqrt(2.0), p);
    EXPECT_NEAR(static_cast<double>(drainage.area[8]), 1 + aside / (down + aside), 1e-6);
    EXPECT_NEAR(static_cast<double>(drainage.area[7]), 3, 1e-6) << "all of it, at last";
    EXPECT_NEAR(drainage.outflow, 3, 1e-12) << "exponent " << p;
  }
}

TEST(Area, IsConservedOnRandomGround) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    Grid grid = rough(seed, 31, 37, seed % 2 == 0 ? 7 : 100'000, seed % 3 == 0 ? 0.03 : 0);
    fill(grid);
    for (const auto routing : {Routing::freeman, Routing::d8}) {
      const auto to = receivers(grid, routing);
      const auto drainage = accumulate(grid, to);
      const double total = total_area(grid);
      EXPECT_NEAR(drainage.outflow, total, 1e-9 * total) << "seed " << seed;
      const Neighbours neighbours(grid);
      for (std::size_t c = 0; c < grid.size(); ++c) {
        if (!grid.valid(c)) continue;
        ASSERT_FALSE(std::isnan(drainage.area[c])) << "no cycle leaves a cell out";
        EXPECT_TRUE(to[c] != 0 || neighbours.valid(c) != 0xff) << "water stays nowhere inside";
        EXPECT_LE(std::popcount(to[c]), routing == Routing::d8 ? 1 : 8);
      }
    }
  }
}

TEST(Area, OfAPlaneByD8CountsTheCellsUphill) {
  const Grid grid = plane(6);
  const auto drainage = accumulate(grid, receivers(grid, Routing::d8));
  // Along the diagonal: every cell's water comes from the one before it.
  for (std::int32_t n = 0; n < 5; ++n) {
    EXPECT_FLOAT_EQ(drainage.area[grid.index(n, n)], 9 * static_cast<float>(n + 1));
  }
}

TEST(StreamPower, IsTheRootOfTheAreaTimesTheSlope) {
  const Grid grid = plane(5);
  const auto s = slope(grid);
  const auto drainage = accumulate(grid, receivers(grid, Routing::d8));
  const auto power = stream_power(drainage, s);
  const auto c = grid.index(2, 2);
  EXPECT_NEAR(static_cast<double>(s[c]), std::sqrt(5.0) / 3, 1e-6);
  EXPECT_NEAR(static_cast<double>(power[c]), std::sqrt(27.0) * std::sqrt(5.0) / 3, 1e-5);
}

}  // namespace
}  // namespace hoodoo::hydrology
