#include "engine/tree/pack.hpp"

#include <gtest/gtest.h>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

Node points(int count, double energy = 1) {
  Node blend{Blend{}, {}};
  for (int i = 0; i < count; ++i) {
    blend.children.push_back({dot_at({0.7 * i, 0.3 * i, 0}, 1 + 0.1 * i, energy / (1 + i)), {}});
  }
  return blend;
}

TEST(Pack, MakesABlendOfPointsOneNodeWithTheSameBits) {
  const Node many = points(20), packed = pack(many);
  ASSERT_TRUE(std::holds_alternative<PointSet>(packed.value));
  EXPECT_EQ(std::get<PointSet>(packed.value).balls.size(), 20U);
  for (int i = 0; i < 200; ++i) {
    const Vec3 at{0.1 * i - 3, 0.04 * i, 0.01 * i};
    EXPECT_EQ(value(packed, at), value(many, at)) << i;
  }
}

TEST(Pack, KeepsTheEnergyOfTheBlend) {
  Node many = points(9);
  many.value = Blend{-0.5};
  const Node packed = pack(many);
  ASSERT_TRUE(std::holds_alternative<Blend>(packed.value));
  ASSERT_EQ(packed.children.size(), 1U);
  EXPECT_EQ(value(packed, {1, 0, 0}), value(many, {1, 0, 0}));
}

TEST(Pack, LeavesAFewAsTheyAre) { EXPECT_EQ(pack(points(7)), points(7)); }

TEST(Pack, PutsOnlyLikeNeighboursTogether) {
  Node blend{Blend{}, {}};
  for (int i = 0; i < 30; ++i) {
    Sphere s = ball({1.0 * i, 0, 0}, 2, i < 10 ? 3 : 4, -1);
    if (i >= 20) s.turbulence.amplitude = 0.5;
    blend.children.push_back({s, {}});
  }
  blend.children.push_back({Strata{}, {}});
  const Node packed = pack(blend);
  ASSERT_EQ(packed.children.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto* set = std::get_if<SphereSet>(&packed.children[i].value);
    ASSERT_NE(set, nullptr) << i;
    EXPECT_EQ(set->balls.size(), 10U);
    EXPECT_EQ(set->falloff, i == 0 ? 3 : 4);
    EXPECT_EQ(set->turbulence.amplitude, i == 2 ? 0.5 : 0);
  }
  EXPECT_EQ(count(packed), 35U);
  for (int i = -5; i < 35; ++i) {
    EXPECT_NEAR(value(packed, {1.0 * i, 1, 0.5}), value(blend, {1.0 * i, 1, 0.5}), 1e-5);
  }
}

TEST(Pack, LooksBelowOtherNodes) {
  Translate by;
  by.by = {5, 0, 0};
  const Node packed = pack({Difference{}, {points(3), {by, {points(12)}}}});
  EXPECT_TRUE(std::holds_alternative<PointSet>(packed.children[1].children[0].value));
  EXPECT_EQ(packed.children[0], points(3));
}

}  // namespace
}  // namespace hoodoo::tree
