#include "tiling/volume/volume.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <vector>

#include "engine/base/random.hpp"

namespace hoodoo::volume {
namespace {

using Edge = std::tuple<int, Index>;

std::vector<Edge> crossed_edges(const Volume& volume) {
  std::vector<Edge> edges;
  volume.for_each_crossing([&](int axis, const Index& p) { edges.emplace_back(axis, p); });
  return edges;
}

/// Random signs in a box that neither begins nor ends with a block.
Volume random_volume(std::uint64_t seed) {
  const Index low{-5, 14, -18}, high{20, 33, 3};
  Volume volume(low, high);
  for (auto k = low[2]; k <= high[2]; ++k) {
    for (auto j = low[1]; j <= high[1]; ++j) {
      for (auto i = low[0]; i <= high[0]; ++i) {
        volume.set_solid({i, j, k}, (random_bits(seed, i, j, k) & 3) == 0);
      }
    }
  }
  return volume;
}

TEST(Volume, IsAirWithoutABlockAtFirst) {
  const Volume volume({0, 0, 0}, {32, 32, 16});
  EXPECT_FALSE(volume.solid({0, 0, 0}));
  EXPECT_FALSE(volume.solid({32, 32, 16}));
  EXPECT_EQ(volume.block({1, 1, 0}), nullptr);
  EXPECT_EQ(volume.block_high(), (Index{3, 3, 2}));
  EXPECT_TRUE(crossed_edges(volume).empty());
}

TEST(Volume, TurnsAUniformBlockIntoOneThatKeepsItsPoints) {
  Volume volume({-16, 0, 0}, {16, 16, 16});
  volume.set_uniform({-1, 0, 0}, true);
  volume.set_solid({-9, 3, 5}, false);
  EXPECT_TRUE(volume.solid({-16, 0, 0}));
  EXPECT_TRUE(volume.solid({-8, 3, 5}));
  EXPECT_FALSE(volume.solid({-9, 3, 5}));
  EXPECT_FALSE(volume.solid({0, 3, 5}));
}

TEST(Volume, FindsEveryCrossedEdgeOfTheClosedBoxAndNoOther) {
  auto volume = random_volume(4);
  volume.mark();
  const auto [low, high] = std::pair(volume.low(), volume.high());
  std::size_t expected = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (auto k = low[2]; k <= high[2]; ++k) {
      for (auto j = low[1]; j <= high[1]; ++j) {
        for (auto i = low[0]; i <= high[0]; ++i) {
          const Index p{i, j, k};
          Index q = p;
          ++q[a];
          const bool crossed = q[a] <= high[a] && volume.solid(p) != volume.solid(q);
          ASSERT_EQ(volume.crossed(axis, p), crossed);
          expected += crossed ? 1 : 0;
        }
      }
    }
  }
  EXPECT_EQ(crossed_edges(volume).size(), expected);
}

TEST(Volume, KeepsOneCrossingPerEdge) {
  auto volume = random_volume(7);
  volume.mark();
  std::uint16_t n = 0;
  volume.for_each_crossing(
      [&](int axis, const Index& p) { volume.crossing(axis, p).material = n++; });
  std::uint16_t m = 0;
  volume.for_each_crossing(
      [&](int axis, const Index& p) { ASSERT_EQ(volume.crossing(axis, p).material, m++); });
}

TEST(Volume, StoresAUniformBlockThatOwnsACrossedEdge) {
  Volume volume({0, 0, 0}, {32, 16, 16});
  volume.set_uniform({0, 0, 0}, true);
  volume.set_uniform({0, 1, 0}, true);
  volume.set_uniform({0, 0, 1}, true);
  volume.set_uniform({0, 1, 1}, true);
  volume.mark();
  EXPECT_NE(volume.block({0, 0, 0}), nullptr);
  EXPECT_EQ(volume.block({1, 0, 0}), nullptr);
  EXPECT_EQ(crossed_edges(volume).size(), 17U * 17U);
  EXPECT_TRUE(volume.crossed(0, {15, 16, 16}));
}

TEST(Volume, LeavesOutEdgesThatNoMeshedCellTouches) {
  Volume volume({0, 0, 0}, {4, 4, 4});
  volume.set_in_world(1, 2, false);
  for (std::int64_t j = 0; j < 5; ++j) {
    for (std::int64_t i = 0; i < 5; ++i) volume.set_solid({i, j, 0}, true);
  }
  volume.mark();
  EXPECT_EQ(crossed_edges(volume).size(), 25U);
  for (std::int64_t j = 0; j < 4; ++j) {
    for (std::int64_t i = 0; i < 4; ++i) volume.set_in_world(i, j, i == 3 && j == 0);
  }
  volume.mark();
  EXPECT_EQ(crossed_edges(volume),
            (std::vector<Edge>{{2, {3, 0, 0}}, {2, {4, 0, 0}}, {2, {3, 1, 0}}, {2, {4, 1, 0}}}));
}

TEST(Volume, KnowsTheWorldOneColumnAroundItsBoxButMeshesOnlyTheBox) {
  Volume volume({0, 0, 0}, {4, 4, 4});
  EXPECT_TRUE(volume.in_world(-1, 4));
  EXPECT_FALSE(volume.meshed(-1, 2));
  EXPECT_FALSE(volume.meshed(4, 2));
  EXPECT_TRUE(volume.meshed(0, 3));
  volume.set_in_world(4, -1, false);
  volume.set_in_world(2, 2, false);
  EXPECT_FALSE(volume.in_world(4, -1));
  EXPECT_TRUE(volume.in_world(-1, -1));
  EXPECT_FALSE(volume.meshed(2, 2));
}

}  // namespace
}  // namespace hoodoo::volume
