#include "engine/scene/brushes.hpp"

#include <gmock/gmock.h>

#include "engine/tree/field.hpp"
#include "engine/tree/ground.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// F of a tree alone, in air.
float value(const tree::Node& tree, const Vec3& p) {
  tree::Ground ground;
  ground.steps.push_back({"", "", tree::Operation::unite, tree, nullptr, -1});
  ground.materials.push_back({"rock", {}, 0, 1, 0.5});
  const auto field = tree::compile(ground, {}, p, Box{p, p}.grown(1));
  const float zero[] = {0};
  float out[1];
  field->values({zero, zero, zero}, out);
  return out[0];
}
bool inside(const tree::Node& tree, const Vec3& p) { return value(tree, p) > 0.5F; }

TEST(SmoothCurve, PassesThroughItsPoints) {
  const std::vector<Vec3> points = {{0, 0, 0}, {10, 5, 0}, {20, -5, 3}, {40, 0, 0}};
  const auto chain = smooth_curve(points, 2);
  EXPECT_GT(chain.size(), 20U);
  EXPECT_EQ(chain.front(), points.front());
  EXPECT_EQ(chain.back(), points.back());
  for (const auto& p : points) EXPECT_THAT(chain, testing::Contains(p));
}

TEST(SmoothCurve, IsStraightBetweenTwoPoints) {
  EXPECT_EQ(smooth_curve({{0, 0, 0}, {9, 0, 0}}, 1).size(), 2U);
}

TEST(SmoothCurve, NeverMakesEndlesslyManyLines) {
  EXPECT_LE(smooth_curve({{0, 0, 0}, {1e6, 0, 0}, {0, 1e6, 0}}, 1e-3).size(), 33U);
}

TEST(SphereBrush, HasItsSurfaceAtItsRadius) {
  SphereBrush ball;
  ball.center = Vec3{10, 20, 30};
  ball.radius = 5;
  const auto tree = ball.build();
  EXPECT_TRUE(inside(tree, {14.9, 20, 30}));
  EXPECT_FALSE(inside(tree, {15.1, 20, 30}));
}

TEST(TunnelBrush, HasItsWallAtItsRadiusAllAlong) {
  TunnelBrush tunnel;
  for (int i = 0; i < 40; ++i) tunnel.path.emplace_back(Vec3{10.0 * i, 0, 0});
  tunnel.radius = 4;
  const auto tree = tunnel.build();
  for (double x = 1; x < 390; x += 7.7) {
    EXPECT_TRUE(inside(tree, {x, 0, 3.9})) << x;
    EXPECT_FALSE(inside(tree, {x, 0, 4.1})) << x;
  }
}

TEST(ArchBrush, LeavesAHoleBelowItsCrown) {
  ArchBrush arch;
  arch.from = Vec3{0, 0, 10};
  arch.to = Vec3{100, 0, 20};
  arch.height = 30;
  arch.thickness = 12;
  const auto tree = arch.build();
  EXPECT_TRUE(inside(tree, {50, 0, 45}));
  EXPECT_TRUE(inside(tree, {50, 0, 50.5}));
  EXPECT_FALSE(inside(tree, {50, 0, 51.5}));
  EXPECT_TRUE(inside(tree, {50, 0, 39.5}));
  EXPECT_FALSE(inside(tree, {50, 0, 38}));
  EXPECT_FALSE(inside(tree, {50, 0, 15}));
  EXPECT_TRUE(inside(tree, {0, 8.5, 10}));  // the thicker foot
  EXPECT_FALSE(inside(tree, {0, 9.5, 10}));
}

TEST(CaveBrush, GoesInAndEndsInAChamber) {
  CaveBrush cave;
  cave.entrance = Vec3{0, 0, 0};
  cave.direction = {1, 0, 0};
  cave.depth = 60;
  cave.radius = 6;
  cave.chamber_radius = 10.0;
  const auto tree = cave.build();
  EXPECT_TRUE(inside(tree, {0, 0, 5.5}));   // the mouth
  EXPECT_TRUE(inside(tree, {-8, 0, 0}));    // open before it
  EXPECT_TRUE(inside(tree, {60, 0, 9.5}));  // the chamber
  EXPECT_TRUE(inside(tree, {69.5, 0, 0}));
  EXPECT_FALSE(inside(tree, {71, 0, 0}));
  EXPECT_FALSE(inside(tree, {30, 0, 14}));  // rock over the passage
}

TEST(CaveBrush, NeverStraysFurtherThanItMay) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    CaveBrush cave;
    cave.direction = {0, 0, -1};
    cave.depth = 100;
    cave.radius = 4;
    cave.winding = 1;
    cave.seed = seed;
    const auto reach = tree::support(cave.build()).influence;
    const double most = 4 * 1.5 + 1.5 * 4 / tree::half_falloff;
    EXPECT_GT(reach.min.x, -most) << seed;
    EXPECT_LT(reach.max.y, most) << seed;
    EXPECT_LT(reach.min.z, -100) << seed;
  }
}

class BrushOperations : public SceneTest {};

TEST_F(BrushOperations, RemoveByTunnelAndCaveAndAddByTheRest) {
  auto scene = minimal();
  scene["operations"] = json::parse(R"([
    {"type": "sphere", "center": [500, 500, 0], "radius": 1},
    {"type": "curve", "points": [[500, 500, 0], [510, 500, 0]], "radius": 1},
    {"type": "tunnel", "path": [[500, 500, 0], [510, 500, 0]], "radius": 1},
    {"type": "arch", "from": [500, 500, 0], "to": [510, 500, 0], "height": 3, "thickness": 1},
    {"type": "cave", "entrance": [500, 500, 0], "direction": [1, 0, 0], "depth": 9, "radius": 1},
    {"type": "cave", "entrance": [500, 500, 0], "direction": [1, 0, 0], "depth": 9, "radius": 1,
     "op": "carve"}])");
  std::vector<tree::Operation> made;
  for (const auto& step : opened(scene).ground.steps) made.push_back(step.operation);
  using tree::Operation;
  EXPECT_THAT(made,
              testing::ElementsAre(Operation::unite, Operation::unite, Operation::difference,
                                   Operation::unite, Operation::difference, Operation::carve));
}

TEST_F(BrushOperations, RefuseRoughnessAsDeepAsTheTube) {
  auto scene = minimal();
  scene["operations"] = json::parse(R"([
    {"type": "tunnel", "path": [[0, 0, 0], [9, 0, 0]], "radius": 2, "turbulence": {"amplitude": 9}}
  ])");
  const auto found = problems(scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].where, "/operations/0/turbulence/amplitude");
}

}  // namespace
}  // namespace hoodoo::scene
