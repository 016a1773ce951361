#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

/// A long box from the origin along x: 0..10, 1 wide, 1 high.
Node beam() {
  BoxNode box;
  box.center = Vec3{5, 0, 0};
  box.size = {10, 1, 1};
  box.falloff = 0.5;
  return {box};
}

TEST(Translate, MovesItsChild) {
  const Node moved{Translate{.by = {100, 20, 3}}, {beam()}};
  EXPECT_EQ(value(moved, {105, 20, 3}), 1);
  EXPECT_NEAR(value(moved, {110, 20, 3}), 0.5, 1e-5);
  EXPECT_EQ(value(moved, {5, 0, 0}), 0);
}

TEST(Rotate, TurnsCounterClockwiseSeenAgainstTheAxis) {
  Rotate turn;
  turn.angle = 90;
  const Node turned{turn, {beam()}};  // x to y
  EXPECT_EQ(value(turned, {0, 5, 0}), 1);
  EXPECT_EQ(value(turned, {5, 0, 0}), 0);
  EXPECT_NEAR(value(turned, {0, 10, 0}), 0.5, 1e-5);
  EXPECT_NEAR(value(turned, {0.5, 5, 0}), 0.5, 1e-5);
  // Steep on the turned face: along +x there.
  const Probe side = probe(turned, {0.5, 5, 0});
  EXPECT_LT(side.gradient.x, -1);
  EXPECT_NEAR(side.gradient.y, 0, 1e-5);
}

TEST(Rotate, TurnsAboutItsPivot) {
  Rotate turn;
  turn.axis = {0, 2, 0};
  turn.angle = -90;  // x to z
  turn.pivot = Vec3{10, 0, 0};
  EXPECT_EQ(value({turn, {beam()}}, {10, 0, -5}), 1);
}

TEST(Scale, StretchesSizesAndFalloffs) {
  Scale twice;
  twice.by = {2, 2, 2};
  const Node large{twice, {{ball({3, 0, 0}, 2, 1)}}};
  EXPECT_NEAR(value(large, {10, 0, 0}), 0.5, 1e-5);
  EXPECT_NEAR(value(large, {2, 0, 0}), 0.5, 1e-5);
  EXPECT_NEAR(value(large, {10.25, 0, 0}), value({ball({0, 0, 0}, 4, 2)}, {4.25, 0, 0}), 1e-5);
  EXPECT_DOUBLE_EQ(support(large).slope, support({ball({3, 0, 0}, 2, 1)}).slope / 2);
}

TEST(Mirror, ShowsItsChildInAPlane) {
  Mirror mirror;
  mirror.point = Vec3{20, 0, 0};
  mirror.normal = {-3, 0, 0};
  const Node image{mirror, {beam()}};
  EXPECT_EQ(value(image, {35, 0, 0}), 1);
  EXPECT_NEAR(value(image, {30, 0, 0}), 0.5, 1e-5);
  EXPECT_EQ(value(image, {5, 0, 0}), 0);
}

TEST(Repeat, PutsItsChildAtEveryPlacement) {
  Repeat many;
  many.placements.resize(2);
  many.placements[0].at = Vec3{100, 0, 0};
  many.placements[1].at = Vec3{0, 50, 10};
  many.placements[1].angle = 90;
  many.placements[1].scale = 2;
  const Node all{many, {beam()}};
  EXPECT_EQ(value(all, {105, 0, 0}), 1);
  EXPECT_EQ(value(all, {0, 60, 10}), 1);
  EXPECT_NEAR(value(all, {0, 70, 10}), 0.5, 1e-5);
  EXPECT_NEAR(value(all, {1, 60, 10}), 0.5, 1e-5);
  EXPECT_EQ(value(all, {5, 0, 0}), 0);
  // One that is out of reach is left out.
  const Node near = prune(all, Box{{90, -9, -9}, {120, 9, 9}}, 0);
  EXPECT_EQ(std::get<Repeat>(near.value).placements.size(), 1u);
}

TEST(Repeat, AddsUpWhereItIsABlend) {
  Repeat many;
  many.placements.resize(3);
  for (Placement& p : many.placements) p.at = Vec3{1, 2, 3};
  const Node child{dot_at({0, 0, 0}, 5, -0.25)};
  EXPECT_EQ(value({many, {child}}, {1, 2, 3}), 0);
  many.join = Repeat::Join::blend;
  EXPECT_NEAR(value({many, {child}}, {1, 2, 3}), -0.75, 1e-5);
}

TEST(Taper, ScalesTheCrossSectionAlongItsAxis) {
  Taper taper;
  taper.axis = {1, 0, 0};
  taper.length = 10;
  taper.factor = 3;
  const Node wedge{taper, {beam()}};
  EXPECT_NEAR(value(wedge, {5, 1, 0}), 0.5, 1e-5);  // twice as wide
  EXPECT_NEAR(value(wedge, {2.5, 0, 0.75}), 0.5, 1e-5);
  EXPECT_EQ(value(wedge, {5, 0.5, -0.5}), 1);
}

TEST(Twist, TurnsWithTheWayAlongItsAxis) {
  Twist twist;
  twist.axis = {1, 0, 0};
  twist.length = 10;
  twist.angle = 180;
  BoxNode plank;
  plank.center = Vec3{5, 0, 0};
  plank.size = {10, 8, 1};
  plank.falloff = 0.5;
  const Node screw{twist, {{plank}}};
  // Half way it stands upright: y has become z.
  EXPECT_EQ(value(screw, {5, 0, 3}), 1);
  EXPECT_EQ(value(screw, {5, 3, 0}), 0);
  EXPECT_NEAR(value(screw, {5, 0, 4}), 0.5, 1e-5);
  // A quarter: y' = y cos 45 - ..., along (0, 1, 1).
  EXPECT_EQ(value(screw, {2.5, 2, 2}), 1);
  EXPECT_EQ(value(screw, {2.5, 2, -2}), 0);
}

TEST(Warp, LeavesWhatItsControlFieldDoesNotReach) {
  Warp bend;
  bend.amplitude = 3;
  bend.wavelength = 4;
  const Node sphere{ball({0, 0, 0}, 10, 4)};
  const Node bent{bend, {sphere, {ball({10, 0, 0}, 4, 4)}}};
  EXPECT_EQ(value(bent, {-10, 0, 0}), value(sphere, {-10, 0, 0}));
  EXPECT_NE(value(bent, {10, 0, 0}), value(sphere, {10, 0, 0}));
  EXPECT_EQ(value({bend, {sphere}}, {13.6, 13.6, 0}), 0);
}

TEST(Warp, MovesPointsBothWaysAboutZero) {
  // A slab-like field: its value tells how far the point was moved in x.
  Plane ramp;
  ramp.point = Vec3{50, 0, 0};
  ramp.normal = {1, 0, 0};
  ramp.falloff = 100;
  Warp bend;
  bend.amplitude = 4;
  bend.wavelength = 7;
  double sum = 0, most = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 p{0, 3.1 * i, 1.7 * i};
    const double slope = probe({ramp}, p).gradient.x;
    const double moved = (value({bend, {{ramp}}}, p) - value({ramp}, p)) / slope;
    sum += moved;
    most = std::max(most, std::abs(moved));
  }
  EXPECT_NEAR(sum / 500, 0, 0.25);
  EXPECT_GT(most, 1.5);
  EXPECT_LT(most, 4.2);
}

}  // namespace
}  // namespace hoodoo::tree
