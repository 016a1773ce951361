// Voxels and the node that evaluates them.
#include "engine/tree/nodes/grid.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <random>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

constexpr Voxels::Placement unit{};

/// Single voxels over a background.
Voxels voxels_of(const std::map<Voxel, float>& values, float background,
                 const Voxels::Placement& placement = unit) {
  std::map<Voxel, std::array<float, Voxels::brick_size>> bricks;
  for (const auto& [v, value] : values) {
    const Voxel from{v[0] & ~7, v[1] & ~7, v[2] & ~7};
    const auto [brick, fresh] = bricks.try_emplace(from);
    if (fresh) brick->second.fill(Voxels::unset);
    const auto n = (v[0] & 7) * 64 + (v[1] & 7) * 8 + (v[2] & 7);
    brick->second[static_cast<std::size_t>(n)] = value;
  }
  Voxels::Builder builder;
  for (const auto& [from, brick] : bricks) builder.brick(from, brick);
  return builder.finish(placement, background);
}

/// f at every voxel of [-4, 12]^3.
template <class F>
Voxels sampled(F f, const Voxels::Placement& placement = unit) {
  std::map<Voxel, float> values;
  for (std::int32_t i = -4; i <= 12; ++i) {
    for (std::int32_t j = -4; j <= 12; ++j) {
      for (std::int32_t k = -4; k <= 12; ++k) values[{i, j, k}] = static_cast<float>(f(i, j, k));
    }
  }
  return voxels_of(values, 0, placement);
}

/// The values as they are, from 0 to 100.
VoxelGrid grid_of(Voxels voxels) {
  VoxelGrid grid;
  grid.voxels = std::move(voxels);
  grid.low = 0;
  grid.high = 100;
  grid.energy = 100;
  return grid;
}

TEST(Voxels, GiveWhatWasSetAndNothingElse) {
  std::map<Voxel, float> values;
  std::mt19937 random(7);
  const auto place = [&](int side) {
    return static_cast<std::int32_t>(random() % static_cast<unsigned>(side)) - side / 2;
  };
  for (int n = 0; n < 2000; ++n) {
    const int side = n % 2 == 0 ? 40 : 20000;
    values[{place(side), place(side), place(side)}] = static_cast<float>(n);
  }
  const Voxels voxels = voxels_of(values, -1);
  Voxels::Cursor cursor(voxels);
  for (const auto& [v, value] : values) ASSERT_EQ(cursor.at(v[0], v[1], v[2]), value);
  for (int n = 0; n < 20000; ++n) {
    const Voxel v{place(44), place(44), place(44)};
    const auto found = values.find(v);
    const float value = cursor.at(v[0], v[1], v[2]);
    if (found == values.end()) {
      ASSERT_TRUE(std::isnan(value));
    } else {
      ASSERT_EQ(value, found->second);
    }
  }
}

TEST(Voxels, HaveTilesOfOneValue) {
  Voxels::Builder builder;
  builder.tile({-4096, 0, 0}, 2, 1);
  builder.tile({0, 128, 256}, 1, 2);
  builder.tile({8, 16, 24}, 0, 3);
  const Voxels voxels = builder.finish(unit, 0);
  Voxels::Cursor cursor(voxels);
  EXPECT_EQ(cursor.at(-1, 4095, 4095), 1);
  EXPECT_EQ(cursor.at(-4096, 0, 0), 1);
  EXPECT_TRUE(std::isnan(cursor.at(-4097, 0, 0)));
  EXPECT_EQ(cursor.at(127, 255, 383), 2);
  EXPECT_TRUE(std::isnan(cursor.at(128, 255, 383)));
  EXPECT_EQ(cursor.at(15, 23, 31), 3);
  EXPECT_TRUE(std::isnan(cursor.at(16, 23, 31)));
  EXPECT_THAT(voxels.low(), testing::ElementsAre(-4096, 0, 0));
  EXPECT_THAT(voxels.high(), testing::ElementsAre(127, 4095, 4095));
  const auto both = voxels.range({8, 16, 24}, {8, 128, 300});
  EXPECT_EQ(both.low, 2);
  EXPECT_EQ(both.high, 3);
  EXPECT_TRUE(both.gaps);
  const auto inside = voxels.range({-100, 5, 5}, {-50, 3000, 3000});
  EXPECT_EQ(inside.low, 1);
  EXPECT_EQ(inside.high, 1);
  EXPECT_FALSE(inside.gaps);
}

TEST(Voxels, KnowTheRangeOfABox) {
  std::map<Voxel, float> values;
  std::mt19937 random(3);
  const auto below = [&](int n) {
    return static_cast<std::int32_t>(random() % static_cast<unsigned>(n));
  };
  for (int n = 0; n < 9000; ++n) {
    values[{below(30), below(30), below(30) - 15}] = static_cast<float>(below(1000));
  }
  const Voxels voxels = voxels_of(values, 0);
  for (int n = 0; n < 300; ++n) {
    const Voxel from{below(34) - 2, below(34) - 2, below(34) - 17};
    const Voxel to{from[0] + below(12), from[1] + below(12), from[2] + below(12)};
    VoxelRange expected;
    for (auto i = from[0]; i <= to[0]; ++i) {
      for (auto j = from[1]; j <= to[1]; ++j) {
        for (auto k = from[2]; k <= to[2]; ++k) {
          const auto found = values.find({i, j, k});
          expected.add(found == values.end() ? Voxels::unset : found->second);
        }
      }
    }
    const auto range = voxels.range(from, to);
    ASSERT_EQ(range.low, expected.low);
    ASSERT_EQ(range.high, expected.high);
    ASSERT_EQ(range.gaps, expected.gaps);
  }
  const auto all = voxels.range({-100, -100, -100}, {100, 100, 100});
  EXPECT_EQ(all.low, voxels.range().low);
  EXPECT_EQ(all.high, voxels.range().high);
}

TEST(Voxels, AreNamedByTheirContentInWhateverOrderItCame) {
  const auto made = [](bool turned, float last, double size, float background) {
    std::array<float, Voxels::brick_size> one{}, two{};
    one.fill(1);
    two.fill(last);
    Voxels::Builder builder;
    builder.brick(turned ? Voxel{-8, 0, 0} : Voxel{800, 0, 8}, turned ? two : one);
    builder.brick(turned ? Voxel{800, 0, 8} : Voxel{-8, 0, 0}, turned ? one : two);
    Voxels::Placement placement;
    placement.linear[0][0] = size;
    return builder.finish(placement, background).digest();
  };
  EXPECT_EQ(made(false, 2, 1, 0), made(true, 2, 1, 0));
  EXPECT_NE(made(false, 2, 1, 0), made(false, 3, 1, 0));
  EXPECT_NE(made(false, 2, 1, 0), made(false, 2, 2, 0));
  EXPECT_NE(made(false, 2, 1, 0), made(false, 2, 1, 5));
}

TEST(VoxelGrid, HasTheFilesValuesAtVoxelCentres) {
  const Node tree{
      grid_of(voxels_of({{{0, 0, 0}, 8.0F}, {{1, 0, 0}, 16.0F}, {{-1, 5, 9}, 31.0F}}, 0))};
  EXPECT_EQ(value(tree, {0, 0, 0}), 8);
  EXPECT_EQ(value(tree, {1, 0, 0}), 16);
  EXPECT_EQ(value(tree, {-1, 5, 9}), 31);
  EXPECT_EQ(value(tree, {3, 3, 3}), 0);
}

TEST(VoxelGrid, IsTrilinearBetweenThem) {
  const Node tree{
      grid_of(voxels_of({{{0, 0, 0}, 8.0F}, {{1, 0, 0}, 16.0F}, {{0, 1, 0}, 24.0F}}, 0))};
  // 8 * 3/4 * 1/2 + 16 * 1/4 * 1/2 + 24 * 3/4 * 1/2, half of it at half a voxel above.
  const Probe at = probe(tree, {0.25, 0.5, 0.5});
  EXPECT_EQ(at.f, (8 * 0.375 + 16 * 0.125 + 24 * 0.375) / 2);
  EXPECT_EQ(at.gradient.x, ((16 - 8) * 0.5 + (0 - 24) * 0.5) / 2);
  EXPECT_EQ(at.gradient.y, ((24 - 8) * 0.75 + (0 - 16) * 0.25) / 2);
  EXPECT_EQ(at.gradient.z, -(8 * 0.375 + 16 * 0.125 + 24 * 0.375));
}

TEST(VoxelGrid, ReproducesWhatIsLinearByEitherInterpolation) {
  const auto plane = [](double x, double y, double z) { return 40 + 2 * x - y + 0.5 * z; };
  for (const auto way : {VoxelGrid::Interpolation::linear, VoxelGrid::Interpolation::quadratic}) {
    VoxelGrid grid = grid_of(sampled(plane));
    grid.interpolation = way;
    for (const Vec3& p :
         {Vec3{0, 0, 0}, Vec3{1.3, 4.6, 7.9}, Vec3{7.5, 7.5, 8}, Vec3{-2.2, 3, 9.99}}) {
      const Probe at = probe({grid, {}}, p);
      EXPECT_NEAR(at.f, plane(p.x, p.y, p.z), 1e-5);
      EXPECT_NEAR(at.gradient.x, 2, 1e-6);
      EXPECT_NEAR(at.gradient.y, -1, 1e-6);
      EXPECT_NEAR(at.gradient.z, 0.5, 1e-6);
    }
  }
}

TEST(VoxelGrid, IsSmoothWhereItIsQuadratic) {
  VoxelGrid grid =
      grid_of(sampled([](int i, int j, int k) { return (i * 7 + j * 3 + k * 5) % 11; }));
  const auto jump = [&] {
    double most = 0;
    for (double x = 1; x < 6; x += 0.5) {  // the planes where either changes its voxels
      const Vec3 a = probe({grid, {}}, {x - 1e-4, 2.3, 3.4}).gradient;
      const Vec3 b = probe({grid, {}}, {x + 1e-4, 2.3, 3.4}).gradient;
      most = std::max(most, length(a - b));
    }
    return most;
  };
  EXPECT_GT(jump(), 1);
  grid.interpolation = VoxelGrid::Interpolation::quadratic;
  EXPECT_LT(jump(), 0.01);
}

TEST(VoxelGrid, LiesWhereTheFileAndTheSceneSay) {
  Voxels::Placement placement;
  placement.linear = {{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  placement.shift = {10, 20, 30};
  VoxelGrid grid = grid_of(voxels_of({{{1, 2, 3}, 5.0F}}, 0, placement));
  EXPECT_EQ(value({grid, {}}, {12, 24, 36}), 5);
  grid.origin = Vec3{100, 0, -6};
  EXPECT_EQ(value({grid, {}}, {112, 24, 30}), 5);
  grid.origin = Vec3{0, 0, 0};
  grid.metres = 0.5;
  EXPECT_EQ(value({grid, {}}, {6, 12, 18}), 5);
  grid.metres = 1;
  grid.up = VoxelGrid::Up::y;  // x stays, y becomes z, z comes to the south
  EXPECT_EQ(value({grid, {}}, {12, -36, 24}), 5);
  const Box box = support({grid, {}}).influence;
  EXPECT_TRUE(box.contains(Vec3{10, -38, 22}) && box.contains(Vec3{14, -34, 26}));
  EXPECT_FALSE(box.contains(Vec3{9.99, -36, 24}));
  EXPECT_FALSE(box.contains(Vec3{12, -36, 26.01}));
}

TEST(VoxelGrid, MapsARangeToNothingAndThePeak) {
  VoxelGrid grid =
      grid_of(voxels_of({{{0, 0, 0}, 50.0F}, {{4, 0, 0}, 1000.0F}, {{8, 0, 0}, -3.0F}}, 7));
  grid.low = 0;
  grid.high = 200;
  grid.energy = -0.5;
  EXPECT_EQ(value({grid, {}}, {0, 0, 0}), -0.125);
  EXPECT_EQ(value({grid, {}}, {4, 0, 0}), -0.5);
  EXPECT_EQ(length(probe({grid, {}}, {4, 0, 0}).gradient), 0);  // held there
  EXPECT_EQ(value({grid, {}}, {8, 0, 0}), 0);
  grid.energy = 1;
  grid.low = 2;  // a distance: 1 inside, 0 two metres outside
  grid.high = -2;
  EXPECT_EQ(value({grid, {}}, {8, 0, 0}), 1);
  EXPECT_EQ(value({grid, {}}, {0, 0, 0}), 0);
}

TEST(VoxelGrid, HasItsBackgroundWhereNothingIsSet) {
  VoxelGrid grid = grid_of(voxels_of({{{0, 0, 0}, 0.0F}}, 25));
  EXPECT_EQ(value({grid, {}}, {0, 0, 0}), 0);
  EXPECT_EQ(value({grid, {}}, {0.5, 0, 0}), 12.5);
  EXPECT_EQ(value({grid, {}}, {1000, 0, 0}), 25);
  EXPECT_EQ(support({grid, {}}).influence, Box::everywhere());
  grid.background = 0;
  EXPECT_EQ(value({grid, {}}, {0.5, 0, 0}), 0);
  EXPECT_EQ(value({grid, {}}, {1000, 0, 0}), 0);
  EXPECT_NE(support({grid, {}}).influence, Box::everywhere());
}

TEST(VoxelGrid, IsBoundedByTheVoxelsInReach) {
  const VoxelGrid grid = grid_of(sampled([](int i, int, int) { return 10 + i; }));
  const Compiled here = compile({grid, {}}, {{2.2, 3, 3}, {{2.2, 3, 3}, {3.7, 4, 4}}});
  EXPECT_NEAR(here.bounds.low, 12, 0.01);
  EXPECT_NEAR(here.bounds.high, 14, 0.01);
  const Compiled away = compile({grid, {}}, {{50, 3, 3}, {{50, 3, 3}, {60, 4, 4}}});
  EXPECT_EQ(away.kernel, nullptr);
  EXPECT_EQ(away.bounds, (Interval{0, 0}));
}

TEST(VoxelGrid, IsLeftOutOfWhatItDoesNotReach) {
  const Node tree{grid_of(sampled([](int, int, int) { return 1; }))};
  EXPECT_EQ(prune(tree, {{0, 0, 0}, {1, 1, 1}}, 0), tree);
  EXPECT_NE(prune(tree, {{20, 0, 0}, {30, 1, 1}}, 0), tree);
}

TEST(VoxelGrid, IsNothingWithoutVoxels) {
  const Node tree{VoxelGrid{}};
  EXPECT_EQ(value(tree, {0, 0, 0}), 0);
  EXPECT_TRUE(support(tree).influence.empty());
}

}  // namespace
}  // namespace hoodoo::tree
