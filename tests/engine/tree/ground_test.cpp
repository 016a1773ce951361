#include "engine/tree/ground.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "engine/tree/region.hpp"
#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

const Box everywhere = Box{{0, 0, 0}, {0, 0, 0}}.grown(1e4);

Step step(Operation operation, Node tree) {
  return {"", "", operation, std::move(tree), nullptr, -1};
}

TEST(Prune, DropsOperationsThatDoNotReach) {
  Ground g;
  g.steps = {step(Operation::unite, {ball({0, 0, 0}, 5, 2)}),
             step(Operation::carve, {ball({100, 0, 0}, 5, 2)})};
  const Ground near = prune(g, Box{{0, 0, 0}, {0, 0, 0}}.grown(20), 0);
  ASSERT_EQ(near.steps.size(), 1u);
  EXPECT_EQ(near.steps[0].tree, g.steps[0].tree);
}

TEST(Prune, KeepsAnIntersectionThatLeavesNothing) {
  Ground g;
  g.steps = {step(Operation::intersect, {ball({100, 0, 0}, 5, 2)})};
  EXPECT_EQ(prune(g, Box{{0, 0, 0}, {0, 0, 0}}.grown(20), 0).steps.size(), 1u);
}

TEST(Prune, DropsOperationsWhoseRegionDoesNotReach) {
  Ground g;
  g.steps = {step(Operation::unite, {ball({0, 0, 0}, 500, 2)})};
  Region region;
  region.box.min.x = 50;
  region.feather = 10;
  g.steps[0].region = std::make_shared<const Region>(region);
  EXPECT_EQ(prune(g, {{0, 0, 0}, {40, 9, 9}}, 0).steps.size(), 0u);
  EXPECT_EQ(prune(g, {{0, 0, 0}, {46, 9, 9}}, 0).steps.size(), 1u);
}

TEST(Prune, DropsTheTermsOfASumThatDoNotReach) {
  Blend sum;
  Node tree{sum, {}};
  for (int i = 0; i < 100; ++i) tree.children.push_back({dot_at({10.0 * i, 0, 0}, 2)});
  const Node cut = prune(tree, {{195, -1, -1}, {205, 1, 1}}, 0);
  // The first holds its place; 19, 20 and 21 lie within R = 4.4 m.
  EXPECT_LE(cut.children.size(), 4u);
  EXPECT_EQ(value(cut, {200, 1, 0}), value(tree, {200, 1, 0}));
}

TEST(Prune, LeavesOutWhatIsTooThin) {
  BoxNode sheet;
  sheet.size = {10, 10, 0.5};
  const Node tree{Union{}, {{ball({0, 0, 0}, 5, 2)}, {ball({9, 0, 0}, 0.4, 2)}, {sheet}}};
  EXPECT_EQ(count(prune(tree, everywhere, 0.4)), 4u);
  const Node coarse = prune(tree, everywhere, 1);
  EXPECT_EQ(coarse.children.at(0), tree.children[0]);
  EXPECT_EQ(value(coarse, {9, 0, 0}), 0);
  // A thickness grows with the scale around it.
  Scale large;
  large.by = {3, 3, 3};
  EXPECT_EQ(count(prune({large, {{ball({9, 0, 0}, 0.4, 2)}}}, everywhere, 1)), 2u);
}

TEST(Prune, KeepsTheZeroThatAUnionNeeds) {
  const Node tree{Union{}, {{ball({100, 0, 0}, 5, 2)}, {ball({0, 0, 0}, 5, 2, -1)}}};
  EXPECT_EQ(value(tree, {0, 0, 0}), 0);
  EXPECT_EQ(value(prune(tree, Box{{0, 0, 0}, {0, 0, 0}}.grown(2), 0), {0, 0, 0}), 0);
}

TEST(Prune, DoesNotTellOneDistantThingFromAnother) {
  const Box reach = Box{{0, 0, 0}, {0, 0, 0}}.grown(20);
  Ground a, b;
  a.steps = {
      step(Operation::unite, {Union{}, {{ball({0, 0, 0}, 5, 2)}, {ball({90, 0, 0}, 5, 2)}}})};
  b.steps = {
      step(Operation::unite, {Union{}, {{ball({0, 0, 0}, 5, 2)}, {ball({80, 0, 0}, 9, 3)}}})};
  EXPECT_EQ(to_json(prune(a, reach, 0)), to_json(prune(b, reach, 0)));
}

TEST(Influence, HoldsTreesAndRegions) {
  Ground g;
  EXPECT_TRUE(influence(g).empty());
  g.steps = {step(Operation::unite, {ball({0, 0, 0}, 5, 2)})};
  EXPECT_NEAR(influence(g).max.x, 5 + 2 * (1 - half_falloff), 1e-3);
  Region region;
  region.box.max.x = 3;
  g.steps[0].region = std::make_shared<const Region>(region);
  EXPECT_EQ(influence(g).max.x, 3);
}

TEST(ToJson, IsTheSameForEqualGroundsAndDiffersForOthers) {
  Ground g;
  g.bodies = {{"land", 4, false, false, 0, {{0, 0}, {1, 0}, {0, 1}}}};
  g.materials = {{"rock", {1, 2, 3}, 0, 1, 0.5}};
  g.steps = {step(Operation::unite, {ball({0, 0, 0}, 5, 2)})};
  const std::string text = to_json(g).dump();
  EXPECT_EQ(to_json(Ground(g)).dump(), text);
  Ground other = g;
  other.bodies[0].falloff = 5;
  EXPECT_NE(to_json(other).dump(), text);
  other = g;
  other.steps[0].material = 0;
  EXPECT_NE(to_json(other).dump(), text);
  other = g;
  other.steps[0].where = "/operations/7";  // where it stands in the scene file changes nothing
  EXPECT_EQ(to_json(other).dump(), text);
}

}  // namespace
}  // namespace hoodoo::tree
