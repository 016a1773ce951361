#include "engine/tree/field.hpp"

#include <gtest/gtest.h>

#include "engine/tree/region.hpp"
#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

/// Level ground at z = 0, R = 4: F = 1 below -4.
class Level : public testing::Test {
 protected:
  Level() {
    ground.bodies.push_back({"land", 4, false, false, 0, {}});
    ground.materials = {{"soft", {}, 0, 0.5, 0}, {"hard", {}, 0.5, 1, 0}};
    windows.emplace_back(-100, -100, 10, 10, 0, 0, 20, 20, std::vector<float>(400, 0.0F));
  }
  void step(Operation operation, Node tree, int material = -1,
            std::shared_ptr<const Region> region = nullptr) {
    ground.steps.push_back({"", "", operation, std::move(tree), std::move(region), material});
  }
  std::unique_ptr<const Field> field(const Vec3& p) const {
    return compile(ground, windows, p, Box{p, p}.grown(1));
  }
  double value(const Vec3& p) const {
    const float zero = 0;
    float f = -1;
    field(p)->values({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {&f, 1});
    return static_cast<double>(f);
  }
  int material(const Vec3& p) const {
    const float zero = 0;
    int m = -1;
    field(p)->materials({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {&m, 1});
    return m;
  }
  double resistance(const Vec3& p) const {
    const float zero = 0;
    float rho = -1;
    field(p)->resistances({{&zero, 1}, {&zero, 1}, {&zero, 1}}, {&rho, 1});
    return static_cast<double>(rho);
  }
  Ground ground;
  std::vector<dem::Window> windows;
};

TEST_F(Level, ClampsAfterEveryOperationSoThatOrderMatters) {
  const Node plus{dot_at({0, 0, -50}, 5, 2)}, minus{dot_at({0, 0, -50}, 5, -0.75)};
  step(Operation::blend, plus);
  step(Operation::blend, minus);
  EXPECT_NEAR(value({0, 0, -50}), 0.25, 1e-6);  // 1 + 2 is held at 1 before 0.75 goes
  std::swap(ground.steps[0], ground.steps[1]);
  EXPECT_EQ(value({0, 0, -50}), 1);
}

TEST_F(Level, AppliesEachOperation) {
  const Node half{dot_at({0, 0, -50}, 5, 0.5)};  // 0.5 at its centre
  const std::vector<std::pair<Operation, double>> below{{Operation::blend, 1},
                                                        {Operation::carve, 0.5},
                                                        {Operation::unite, 1},
                                                        {Operation::difference, 0.5},
                                                        {Operation::intersect, 0.5}};
  for (const auto& [operation, f] : below) {
    ground.steps.clear();
    step(operation, half);
    EXPECT_NEAR(value({0, 0, -50}), f, 1e-6);
    EXPECT_EQ(value({50, 0, -50}), operation == Operation::intersect ? 0 : 1);
  }
  const std::vector<std::pair<Operation, double>> above{{Operation::blend, 0.5},
                                                        {Operation::carve, 0},
                                                        {Operation::unite, 0.5},
                                                        {Operation::difference, 0},
                                                        {Operation::intersect, 0}};
  for (const auto& [operation, f] : above) {
    ground.steps.clear();
    step(operation, {dot_at({0, 0, 50}, 5, 0.5)});
    EXPECT_NEAR(value({0, 0, 50}), f, 1e-6);
  }
}

/// At the points of a block from (0, 0, -8) on, 1 m apart.
TEST_F(Level, OfAGridAsksTheRowsThatABallReachesAndNoOthers) {
  std::vector<float> along(16), out(16 * 16 * 16);
  for (std::size_t i = 0; i < 16; ++i) along[i] = static_cast<float>(i);
  const auto asked = [&] {
    const Box block{{0, 0, -8}, {16, 16, 8}};
    return compile(ground, windows, block.min, block)->grid({along, along, along}, out);
  };
  const auto ball_of = [](const Vec3& center, double reach) {
    PointSet set;
    set.balls = Balls({{center, reach * half_falloff, 1}});
    return Node{set, {}};
  };
  EXPECT_EQ(asked(), 0U);
  step(Operation::blend, ball_of({5, 5, 0}, 2.5));
  EXPECT_EQ(asked(), 16U * 21U);  // columns within 2.5 m
  step(Operation::carve, ball_of({7, 5, 3}, 1.5));
  EXPECT_EQ(asked(), 16U * (21U + 3U));  // six of its nine were asked already
  step(Operation::intersect, ball_of({7, 5, 3}, 1.5));
  EXPECT_EQ(asked(), out.size());  // it is 0 beyond the tree's reach
}

TEST_F(Level, MixesTheResultWithWhatWasByTheRegion) {
  Region region;
  region.box.min.x = 0;
  region.feather = 2;
  step(Operation::carve, {ball({0, 0, -50}, 20, 4)}, -1, std::make_shared<const Region>(region));
  EXPECT_EQ(value({5, 0, -50}), 0);
  EXPECT_EQ(value({-5, 0, -50}), 1);
  EXPECT_NEAR(value({0, 0, -50}), 0.5, 1e-6);
}

TEST_F(Level, TakesTheMaterialOfTheLastOperationThatChangedF) {
  step(Operation::unite, {ball({0, 0, 10}, 5, 2)}, 1);
  step(Operation::unite, {ball({0, 0, 10}, 2, 2)}, 0);   // changes nothing: F is 1 there
  step(Operation::carve, {ball({0, 0, 14}, 2, 2)}, -1);  // has none of its own
  EXPECT_EQ(material({0, 0, 10}), 1);
  EXPECT_EQ(material({0, 0, 13.5}), 1);
}

TEST_F(Level, TakesTheMaterialWhoseRangeHoldsTheResistance) {
  EXPECT_EQ(resistance({0, 0, -5}), 0.5);  // without a geology
  EXPECT_EQ(material({0, 0, -5}), 1);      // half-open ranges
  Plane plane;
  plane.point = Vec3{0, 0, -5};
  plane.falloff = 10;
  plane.energy = 3;
  ground.geology = Node{plane};
  EXPECT_EQ(resistance({0, 0, -5}), 1);  // clamped
  EXPECT_EQ(material({0, 0, -5}), 1);    // the last range is closed
  EXPECT_EQ(material({0, 0, -20}), 0);
  ground.materials = {{"a", {}, 0.1, 0.2, 0}, {"b", {}, 0.6, 0.7, 0}};
  EXPECT_EQ(material({0, 0, -20}), 0);  // a gap takes the nearest
  EXPECT_EQ(material({0, 0, -5}), 1);
}

TEST_F(Level, TakesTheMaterialOfTheFirstSeamThatHoldsThePoint) {
  ground.materials.push_back({"coal", {}, 0, 1, 0, "coal"});
  ground.materials.push_back({"salt", {}, 0, 1, 0, "salt"});
  ground.seams = {{2, {ball({0, 0, -20}, 5, 2)}}, {3, {ball({0, 0, -24}, 5, 2)}}};
  EXPECT_EQ(material({0, 0, -20}), 2);
  EXPECT_EQ(material({0, 0, -24.5}), 2);  // both hold it
  EXPECT_EQ(material({0, 0, -28}), 3);
  EXPECT_EQ(material({0, 0, -40}), 1);  // by resistance 1/2; those bound to strata have no range
  step(Operation::unite, {ball({0, 0, 2}, 5, 2)}, 0);
  ground.seams[0].tree = {ball({0, 0, 5}, 5, 2)};
  EXPECT_EQ(material({0, 0, 5}), 0);  // an operation's own comes first
}

TEST_F(Level, GivesTheElevationsWhereNoOperationReaches) {
  step(Operation::difference, {ball({0, 0, 0}, 5, 2)});
  EXPECT_EQ(field({50, 0, 0})->height_field(), &windows[0]);
  EXPECT_EQ(field({5, 0, 0})->height_field(), nullptr);
}

TEST_F(Level, IsUniformFarFromTheGround) {
  EXPECT_GT(field({0, 0, -50})->bounds().low, 0.5);
  EXPECT_LT(field({0, 0, 50})->bounds().high, 0.5);
  EXPECT_TRUE(field({0, 0, 0})->bounds().contains(0.5));
}

TEST_F(Level, UnitesItsBodies) {
  ground.bodies.push_back(
      {"island", 4, false, false, 60, {{-50, -50}, {50, -50}, {50, 50}, {-50, 50}}});
  windows.push_back(windows[0]);
  EXPECT_EQ(value({0, 0, 50}), 1);  // under the second ground, inside its domain
  EXPECT_EQ(value({80, 0, 50}), 0);
  EXPECT_EQ(value({80, 0, -50}), 1);
}

TEST_F(Level, LeavesOutABodyWithoutElevations) {
  windows[0] = dem::Window();
  EXPECT_EQ(value({0, 0, -50}), 0);
}

TEST_F(Level, TellsWhatReachesABlock) {
  ground.steps.push_back({"cave",
                          "/operations/0",
                          Operation::difference,
                          {Union{}, {{ball({0, 0, 0}, 5, 2)}, {ball({40, 0, 0}, 5, 2)}}},
                          nullptr,
                          -1});
  EXPECT_EQ(field({0, 0, 0})->explain(),
            (std::vector<std::string>{"terrain land", "difference cave", "  union", "    sphere"}));
  EXPECT_EQ(field({0, 50, 0})->explain(), (std::vector<std::string>{"terrain land"}));
}

TEST_F(Level, HasOneMaterialUnlessGeologyOrAnOperationMakesMore) {
  step(Operation::unite, {dot_at({0, 0, 10}, 5, 2)});
  EXPECT_EQ(field({0, 0, -5})->material(), 1);
  EXPECT_EQ(field({0, 0, 10})->material(), 1);
  step(Operation::unite, {dot_at({0, 0, 10}, 5, 2)}, 0);
  EXPECT_EQ(field({0, 0, -5})->material(), 1);  // the operation does not reach there
  EXPECT_EQ(field({0, 0, 10})->material(), std::nullopt);
  ground.geology = Node{dot_at({0, 0, -5}, 5, 0.2)};
  EXPECT_EQ(field({0, 0, -5})->material(), std::nullopt);
  EXPECT_EQ(field({0, 0, -50})->material(), 0);  // rho is 0 where the geology does not reach
}

}  // namespace
}  // namespace hoodoo::tree
