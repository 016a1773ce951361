#include <gmock/gmock.h>

#include <cmath>

#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

json undercuts(const char* more = "{}") {
  auto operation = json::parse(R"({"type": "overhangs", "distance": 30, "length": 60, "height": 12,
                                   "depth": 20, "steepness": 35})");
  operation.update(json::parse(more));
  return operation;
}

/// The lenses of a scene.
std::vector<tree::Node> lenses(const Scene& scene) {
  if (scene.ground.steps.empty()) return {};
  const auto& all = scene.ground.steps.front().tree;
  if (std::holds_alternative<tree::Union>(all.value)) return children_of(all);
  return {all};
}

class Overhangs : public GrowingTest {
 protected:
  static constexpr double low = 30, high = 42;
  /// Hard rock with a weak layer.
  static json layered(json operation) {
    auto scene = with(std::move(operation));
    scene["geology"] = json::parse(R"j({"type": "expression",
        "formula": "0.95 - 0.85 * clamp(20 * (6 - abs(z - 36)), 0, 1)"})j");
    return scene;
  }
  /// The cliff of the sample, away from the world's edge.
  static Box cliff(double from, double to) { return {{230, 160, from}, {470, 560, to}}; }
};

TEST_F(Overhangs, CutRockAwayUnderRock) {
  const auto before = opened(minimal());
  const auto after = grown(with(undercuts()));
  EXPECT_GT(counted(after, "placed"), 10U);
  EXPECT_EQ(counted(after, "placed"), lenses(after).size());
  const Box box = cliff(0, 120);
  constexpr double step = 4;
  const auto a = solid(before, box, step), b = solid(after, box, step);
  const std::size_t wide = 61, layer = wide * 101;
  std::size_t roofs = 0, before_roofs = 0;
  for (std::size_t i = 0; i + 3 * layer < a.size(); ++i) {
    EXPECT_LE(b[i], a[i]);  // nothing is added
    roofs += !b[i] && b[i + 3 * layer] ? 1 : 0;
    before_roofs += !a[i] && a[i + 3 * layer] ? 1 : 0;
  }
  EXPECT_EQ(before_roofs, 0U);
  EXPECT_GT(roofs, 50U);
}

TEST_F(Overhangs, LieInTheWeakLayer) {
  const auto before = opened(layered(json::parse(R"({"op": "carve", "tree": {"type": "sphere",
      "center": [0, 0, -900], "radius": 1}})")));
  const auto after = grown(layered(undercuts(R"({"beta": 0})")));
  ASSERT_GT(counted(after, "placed"), 0U);
  EXPECT_GT(counted(after, "too weak"), counted(after, "placed"));
  for (const auto& lens : lenses(after)) {
    const auto& row = lens.children.empty() ? lens : lens.children.back();
    const auto& line = std::get<tree::Polyline>(row.value).points;
    for (const auto& p : line) {
      EXPECT_GT(p.value.z, low - 1);
      EXPECT_LT(p.value.z, high + 1);
    }
  }
  // Half a height above and below the layer at most.
  EXPECT_GT(lost(before, after, cliff(low - 8, high + 12), 4), 100U);
  EXPECT_EQ(lost(before, after, cliff(-20, low - 10), 4), 0U);
  EXPECT_EQ(lost(before, after, cliff(high + 16, 120), 4), 0U);
}

TEST_F(Overhangs, AreDeeperInWeakerRock) {
  std::vector<std::size_t> gone;
  for (const char* rho : {"0.1", "0.4", "0.7"}) {
    auto scene = with(undercuts(R"({"beta": 0, "threshold": 0})"));
    scene["geology"] = {{"type", "expression"}, {"formula", rho}};
    gone.push_back(lost(opened(minimal()), grown(scene), cliff(0, 120), 4));
  }
  EXPECT_GT(gone[2], 0U);
  EXPECT_GT(static_cast<double>(gone[1]), 1.3 * static_cast<double>(gone[2]));
  EXPECT_GT(static_cast<double>(gone[0]), 1.2 * static_cast<double>(gone[1]));
}

TEST_F(Overhangs, NeedARoofThatHolds) {
  const auto scene = grown(layered(undercuts(R"({"beta": 0, "roof": 0.5})")));
  const auto any = grown(layered(undercuts(R"({"beta": 0})")));
  EXPECT_EQ(counted(scene, "placed") + counted(scene, "under a weak roof"), counted(any, "placed"));
  EXPECT_GT(counted(scene, "placed"), 0U);
  const auto none = with(undercuts(R"({"roof": 0.6})"));  // rho = 1/2 everywhere
  EXPECT_TRUE(grown(none).ground.steps.empty());
}

TEST_F(Overhangs, AreTheSameForAnyThreadsAndOthersForAnotherSeed) {
  const auto one = trees(grown(with(undercuts()), 1));
  EXPECT_EQ(one, trees(grown(with(undercuts()), 2)));
  EXPECT_NE(one, trees(grown(with(undercuts(R"({"seed": 1})")))));
}

TEST_F(Overhangs, ChangeOnlyInReachOfTheRegion) {
  const auto whole = lenses(grown(with(undercuts())));
  const auto part = lenses(grown(with(
      undercuts(R"({"region": {"type": "box", "min": [0, 0, -100], "max": [1000, 400, 200]}})"))));
  ASSERT_FALSE(part.empty());
  EXPECT_LT(part.size(), whole.size());
  std::size_t same = 0, inside = 0;
  for (const auto& lens : whole) {
    const bool in = tree::support(lens).influence.max.y < 400;
    inside += in ? 1 : 0;
    same += in && std::find(part.begin(), part.end(), lens) != part.end() ? 1 : 0;
  }
  EXPECT_GT(inside, 0U);
  EXPECT_EQ(same, inside);
  for (const auto& lens : part) EXPECT_LT(tree::support(lens).influence.min.y, 400);
}

TEST_F(Overhangs, RefuseWhatIsOutOfRange) {
  EXPECT_EQ(texts(problems(with(undercuts(R"({"length": 0, "steepness": 91, "roof": 2})")))),
            (std::vector<std::string>{"/operations/0/length: must be in (0, 10000] m, got 0",
                                      "/operations/0/steepness: must be in [0, 90] deg, got 91",
                                      "/operations/0/roof: must be in [0, 1], got 2"}));
  EXPECT_EQ(texts(problems(with(undercuts(R"({"height": 1, "depth": 60})")))),
            (std::vector<std::string>{
                "/operations/0/depth: must be at most 50 times \"height\", 50 m, got 60"}));
  EXPECT_THAT(places_of(problems(with(undercuts(R"({"turbulence": {"amplitude": 40}})")))),
              testing::ElementsAre("/operations/0/turbulence/amplitude"));
}

}  // namespace
}  // namespace hoodoo::scene
