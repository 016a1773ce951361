#include "engine/scene/copies.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

/// A rough ball on the sample coast, 1000 x 1000 m of 8 m pixels.
class Copied : public SceneTest {
 protected:
  static json scene(const char* more) {
    auto made = minimal();
    auto ball = json::parse(R"({"id": "ball", "type": "sphere", "radius": 10, "falloff": 4,
                                "center": {"xy": [500, 500], "ground": 3},
                                "turbulence": {"amplitude": 1}})");
    ball.update(json::parse(more));
    made["operations"] = json::array({ball});
    return made;
  }
  static double ground(const Scene& scene, double x, double y) {
    return scene.pyramids[0]->window(0, Box{{x, y, 0}, {x, y, 0}}).height(x, y);
  }
  static Vec3 middle(const tree::Node& tree) {
    const Box box = tree::support(tree).influence;
    return (box.min + box.max) * 0.5;
  }
  static double width(const tree::Node& tree) {
    const Box box = tree::support(tree).influence;
    return box.max.z - box.min.z;
  }
  static std::string failure(const json& scene) {
    try {
      opened(scene);
    } catch (const Error& error) {
      return texts(error.problems).at(0);
    }
    return "";
  }
};

TEST_F(Copied, StandOnTheOtherSideOfTheMirror) {
  const auto made =
      opened(scene(R"({"center": [500, 500, 300], "mirror": {"point": [560, 0], "angle": 90}})"));
  const auto alone = opened(scene(R"({"center": [500, 500, 300]})"));
  std::size_t within = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p{488.0 + 7 * (i % 4), 490.0 + 3 * (i / 4 % 7), 288.0 + 1.7 * (i / 14)};
    EXPECT_EQ(field(made, p), field(alone, p));
    EXPECT_NEAR(field(made, {1120 - p.x, p.y, p.z}), field(alone, p), 1e-4) << i;
    within += field(alone, p) > 0.5F ? 1 : 0;
  }
  EXPECT_GT(within, 30U);
  // The ball itself, and its image.
  EXPECT_GT(field(made, {500, 500, 300}), 0.5F);
  EXPECT_GT(field(made, {620, 500, 300}), 0.5F);
  EXPECT_EQ(tree::count(made.ground.steps[0].tree),
            2 * tree::count(alone.ground.steps[0].tree) + 2);
}

TEST_F(Copied, AreMirroredAlongAnyDirectionInPlan) {
  // Along x = y through the origin of the plan: x and y change places.
  const auto made = opened(scene(R"({"center": [700, 300, 400],
                                     "mirror": {"point": [100, 100], "angle": 45}})"));
  EXPECT_GT(field(made, {700, 300, 400}), 0.5F);
  EXPECT_GT(field(made, {300, 700, 400}), 0.5F);
  EXPECT_LT(field(made, {300, 300, 400}), 0.5F);
}

TEST_F(Copied, VaryAroundTheBrushAsFarOverTheGround) {
  const auto stated = scene(R"({"variants": {"count": 40, "spread": 150, "least_scale": 0.5,
                                             "most_scale": 2}})");
  const auto made = opened(stated);
  const auto bodies = children_of(made.ground.steps[0].tree);
  ASSERT_EQ(bodies.size(), 41U);
  const Vec3 own = middle(bodies[0]);
  EXPECT_NEAR(own.z, ground(made, own.x, own.y) + 3, 0.01);
  std::size_t small = 0, large = 0, far = 0;
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Vec3 p = middle(bodies[i]);
    const double scale = width(bodies[i]) / width(bodies[0]);
    const double away = std::hypot(p.x - own.x, p.y - own.y);
    EXPECT_LE(away, 150.01);
    EXPECT_GE(scale, 0.499);
    EXPECT_LE(scale, 2.001);
    EXPECT_NEAR(p.z, ground(made, p.x, p.y) + 3 * scale, 0.05) << i;
    small += scale < 1.25 ? 1 : 0;
    large += scale > 1.25 ? 1 : 0;
    far += away > 75 ? 1 : 0;
  }
  EXPECT_GT(small, 10U);
  EXPECT_GT(large, 10U);
  EXPECT_NEAR(static_cast<double>(far), 30, 9);  // three quarters of the disk
  EXPECT_EQ(opened(stated).ground.steps[0].tree, made.ground.steps[0].tree);
  auto other = stated;
  other["operations"][0]["variants"]["seed"] = 1;
  EXPECT_NE(opened(other).ground.steps[0].tree, made.ground.steps[0].tree);
}

TEST_F(Copied, AreRoughEachInItsOwnWay) {
  const auto made = opened(scene(R"({"variants": {"count": 5, "spread": 90}})"));
  std::vector<std::uint32_t> seeds;
  for (const auto& body : children_of(made.ground.steps[0].tree)) {
    auto node = body;
    while (!node.children.empty()) node = tree::Node(node.children[0]);
    seeds.push_back(std::get<tree::Sphere>(node.value).turbulence.seed);
  }
  ASSERT_EQ(seeds.size(), 6U);
  EXPECT_EQ(seeds[0], 0U);
  std::ranges::sort(seeds);
  EXPECT_EQ(std::ranges::adjacent_find(seeds), seeds.end());
}

TEST_F(Copied, OfTreesAndCavesAreBothVariedAndMirrored) {
  auto stated = minimal();
  stated["operations"] = json::parse(R"([
    {"op": "carve", "tree": {"type": "box", "center": [400, 500, 60], "size": [9, 5, 7]},
     "variants": {"count": 3, "spread": 50}, "mirror": {"point": [600, 0], "angle": 90}},
    {"type": "cave", "entrance": [500, 600, 60], "direction": [1, 0, 0], "depth": 60, "radius": 5,
     "variants": {"count": 1, "spread": 60, "rotation": 0, "least_scale": 1, "most_scale": 1}}])");
  const auto made = opened(stated);
  const auto both = children_of(made.ground.steps[0].tree);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(children_of(both[0]).size(), 4U);
  EXPECT_TRUE(std::holds_alternative<tree::Mirror>(both[1].value));
  EXPECT_EQ(both[1].children.at(0), both[0]);
  // The other cave is no shifted copy of the first: it winds another way.
  auto caves = children_of(made.ground.steps[1].tree);
  ASSERT_EQ(caves.size(), 2U);
  std::array<std::vector<Vec3>, 2> axes;
  for (std::size_t i = 0; i < 2; ++i) {
    tree::for_each_point(caves[i], [&](tree::Point& p) { axes[i].push_back(p.value); });
  }
  ASSERT_EQ(axes[0].size(), axes[1].size());
  double most = 0;
  for (std::size_t i = 0; i < axes[0].size(); ++i) {
    most = std::max(most, length(axes[1][i] - axes[0][i] - (axes[1][0] - axes[0][0])));
  }
  EXPECT_GT(most, 0.5);
}

TEST_F(Copied, OverAHoleAreLeftOutAndCounted) {
  const auto made = opened(scene(R"({"center": [990, 500, 60],
                                     "variants": {"count": 30, "spread": 100}})"));
  const auto bodies = children_of(made.ground.steps[0].tree);
  EXPECT_GT(bodies.size(), 5U);
  EXPECT_LT(bodies.size(), 28U);
  ASSERT_EQ(made.warnings.size(), 1U);
  EXPECT_EQ(made.warnings[0], "/operations/0/variants: " + std::to_string(31 - bodies.size()) +
                                  " of 30 would stand over no ground and are left out");
}

TEST_F(Copied, NameWhatIsWrong) {
  auto stated = scene(R"({"mirror": {"angle": 700},
                          "variants": {"count": 0, "spread": 9, "least_scale": 2, "turn": 3}})");
  EXPECT_THAT(
      texts(problems(stated)),
      ElementsAre(HasSubstr("/operations/0/mirror/point: is missing"),
                  HasSubstr("/operations/0/mirror/angle: must be in [-360, 360] deg, got 700"),
                  HasSubstr("/operations/0/variants/count: must be in [1, 10000], got 0"),
                  HasSubstr("/operations/0/variants/turn: ")));
  stated = scene(R"({"variants": {"count": 1, "spread": 9, "least_scale": 2}})");
  EXPECT_THAT(texts(problems(stated)),
              ElementsAre("/operations/0/variants/most_scale: must be at least \"least_scale\", 2, "
                          "got 1.25"));
  stated = minimal();
  stated["operations"] = json::parse(
      R"([{"type": "sea_cliffs", "mirror": {"point": [0, 0]},
           "variants": {"count": 1, "spread": 1}}])");
  EXPECT_THAT(texts(problems(stated)),
              ElementsAre("/operations/0/mirror: is for brushes and trees, not for the generator "
                          "\"sea_cliffs\"",
                          "/operations/0/variants: is for brushes and trees, not for the generator "
                          "\"sea_cliffs\""));
  stated["operations"] = json::parse(
      R"([{"op": "carve", "tree": {"type": "half_space", "point": [0, 0, 0], "normal": [0, 0, 1]},
           "variants": {"count": 1, "spread": 1}}])");
  EXPECT_EQ(failure(stated),
            "/operations/0/variants: needs a tree that ends somewhere: this one has no middle");
  EXPECT_THAT(failure(scene(R"({"center": [-200, 0, 0], "variants": {"count": 1, "spread": 1}})")),
              HasSubstr("/operations/0/variants: needs ground below: no terrain has an elevation "
                        "at x = -200.00 m, y = 0.00 m"));
}

}  // namespace
}  // namespace hoodoo::scene
