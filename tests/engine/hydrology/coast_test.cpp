#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/hydrology/accessibility.hpp"
#include "engine/hydrology/percentiles.hpp"
#include "engine/hydrology/sea_distance.hpp"
#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

Grid smooth(std::int32_t side, double height) {
  std::vector<float> z;
  for (std::int32_t j = 0; j < side; ++j) {
    for (std::int32_t i = 0; i < side; ++i) {
      z.push_back(static_cast<float>(height * std::sin(0.3 * i) * std::cos(0.2 * j)));
    }
  }
  return grid_of(side, std::move(z));
}

TEST(Accessibility, IsTheTangentBallOfEveryCell) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const Grid grid =
        seed % 2 == 0 ? rough(seed, 41, 37, seed % 4 == 0 ? 300 : 3, 0.05) : smooth(43, 0.5 * seed);
    const double most = 2.5 * seed;
    const auto values = accessibility(grid, most, {0, grid.height});
    for (std::int32_t j = 0; j < grid.height; ++j) {
      for (std::int32_t i = 0; i < grid.width; ++i) {
        const auto ball = static_cast<float>(tangent_ball(grid, i, j, most) / most);
        const float value = values[grid.index(i, j)];
        ASSERT_TRUE(value == ball || (std::isnan(value) && std::isnan(ball))) << "seed " << seed;
      }
    }
  }
}

TEST(Accessibility, IsWholeOnARidgeAndSmallInAGorge) {
  std::vector<float> ridge, gorge;
  for (int n = 0; n < 21 * 21; ++n) {
    gorge.push_back(static_cast<float>(std::abs(n % 21 - 10)));
    ridge.push_back(-gorge.back());
  }
  const auto high = accessibility(grid_of(21, std::move(ridge)), 8, {0, 21});
  EXPECT_EQ(std::ranges::count(high, 1.0F), 21 * 21);
  const auto low = accessibility(grid_of(21, std::move(gorge)), 8, {10, 11});
  // A ball on the bottom meets the cells beside it: (1 + 1) / (2 * 1) of 8 m.
  EXPECT_FLOAT_EQ(low[10], 1.0F / 8);
  EXPECT_LT(low[12], low[14]);
  EXPECT_LT(low[14], low[16]);
}

TEST(Accessibility, OfSomeRowsDependsOnThoseInReachAlone) {
  const Grid whole = rough(3, 30, 60, 200, 0.02);
  const auto all = accessibility(whole, 7, {0, 60});
  const std::int32_t reach = accessibility_reach(whole, 7);
  ASSERT_LT(reach, 20);
  Grid part = whole;
  part.height = 2 * reach + 5;
  const std::ptrdiff_t first = 10;
  part.z.assign(whole.z.begin() + first * 30, whole.z.begin() + (first + part.height) * 30);
  part.dx.resize(static_cast<std::size_t>(part.height));
  part.dy.resize(static_cast<std::size_t>(part.height));
  const auto rows = accessibility(part, 7, {reach, reach + 5});
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const float expected = all[n + 30 * static_cast<std::size_t>(first + reach)];
    ASSERT_TRUE(rows[n] == expected || (std::isnan(rows[n]) && std::isnan(expected)));
  }
}

/// By all pairs.
float sea_distance_slowly(const Grid& grid, std::int32_t i, std::int32_t j, double level) {
  double best = std::numeric_limits<double>::infinity();
  for (std::int32_t b = 0; b < grid.height; ++b) {
    double north = 0;
    for (std::int32_t k = std::min(j, b); k < std::max(j, b); ++k) {
      const auto row = static_cast<std::size_t>(k);
      north += 0.5 * (grid.dy[row] + grid.dy[row + 1]);
    }
    for (std::int32_t a = 0; a < grid.width; ++a) {
      if (!(static_cast<double>(grid.z[grid.index(a, b)]) <= level)) continue;
      const double east =
          std::abs(a - i) * 0.5 *
          (grid.dx[static_cast<std::size_t>(j)] + grid.dx[static_cast<std::size_t>(b)]);
      best = std::min(best, std::hypot(east, north));
    }
  }
  return static_cast<float>(best);
}

TEST(SeaDistance, IsTheLeastOfAllPairs) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    // Sea in one cell of `levels`, on the lowest of them.
    Grid grid = rough(seed, 37, 90, seed % 3 == 0 ? 2000 : 30, seed % 2 == 0 ? 0.1 : 0);
    for (std::size_t j = 0; j < 90; ++j) {
      grid.dx[j] = 1 + 0.1 * static_cast<double>(j) * (seed % 4);
      grid.dy[j] = 2 + 0.01 * static_cast<double>(j);
    }
    const auto distances = sea_distance(grid, -3);
    for (std::int32_t j = 0; j < grid.height; ++j) {
      for (std::int32_t i = 0; i < grid.width; ++i) {
        const float found = distances[grid.index(i, j)];
        if (!grid.valid(grid.index(i, j))) {
          ASSERT_TRUE(std::isnan(found));
          continue;
        }
        const float expected = sea_distance_slowly(grid, i, j, -3);
        if (std::isinf(expected))
          ASSERT_TRUE(std::isinf(found));
        else
          ASSERT_NEAR(found, expected, 1e-6F * expected) << "seed " << seed << ' ' << i << ' ' << j;
      }
    }
  }
}

TEST(SeaDistance, OfAPlaneCountsItsCells) {
  std::vector<float> z(100 * 80, 5);
  z[0] = 0;
  const auto distances = sea_distance(grid_of(100, std::move(z), 3), 0);
  EXPECT_EQ(distances[0], 0);
  EXPECT_EQ(distances[30 * 100 + 40], 150) << "3, 4, 5";
  EXPECT_EQ(distances[79 * 100], 3 * 79);
}

}  // namespace
}  // namespace hoodoo::hydrology
