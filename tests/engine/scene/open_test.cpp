#include <gmock/gmock.h>

#include "engine/base/file.hpp"
#include "engine/tree/region.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class Open : public SceneTest {
 protected:
  static std::vector<std::string> failure(const json& scene) {
    try {
      opened(scene);
    } catch (const Error& error) {
      return texts(error.problems);
    }
    return {};
  }
  /// Elevation of the first terrain [m].
  static double ground(const Scene& scene, double x, double y) {
    return scene.pyramids[0]->window(0, Box{{x, y, 0}, {x, y, 0}}).height(x, y);
  }
};

TEST_F(Open, GivesEveryValue) {
  const auto scene = opened(minimal());
  EXPECT_EQ(scene.spacing, 8);
  EXPECT_EQ(scene.frame.crs, "EPSG:32612");
  EXPECT_EQ(scene.ground.bodies.size(), 1U);
  EXPECT_EQ(scene.ground.bodies[0].id, "land");
  EXPECT_EQ(scene.ground.bodies[0].falloff, 32);
  EXPECT_EQ(scene.pyramids.size(), 1U);
  EXPECT_EQ(scene.ground.materials.size(), 1U);
  EXPECT_FALSE(scene.ground.geology);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_NEAR(scene.extent.max.x - scene.extent.min.x, 1000, 1e-6);
  EXPECT_LT(scene.extent.min.z, -10);
  EXPECT_GT(scene.extent.max.z, 100);
}

TEST_F(Open, HoldsTheFieldOfItsTerrain) {
  const auto scene = opened(minimal());
  const double h = ground(scene, 604, 404);
  EXPECT_GT(field(scene, {604, 404, h - 4}), 0.5F);
  EXPECT_LT(field(scene, {604, 404, h + 4}), 0.5F);
}

TEST_F(Open, RoundsTheSpacing) {
  auto scene = minimal();
  scene["bake"]["spacing"] = 2.7182818;
  const auto made = opened(scene);
  EXPECT_EQ(made.spacing, dem::rounded_spacing(2.7182818));
  EXPECT_EQ(made.bake.spacing, made.spacing);
  EXPECT_EQ(made.ground.bodies[0].falloff, 4 * made.spacing);
}

TEST_F(Open, ClipsTheWorldToTheExtent) {
  auto scene = minimal();
  scene["bake"]["extent"] = {{"min", {600, -500}}, {"max", {700, 300}}};
  const auto made = opened(scene);
  EXPECT_EQ(made.extent.min.x, 600);
  EXPECT_EQ(made.extent.max.x, 700);
  EXPECT_GE(made.extent.min.y, 0);
  EXPECT_EQ(made.extent.max.y, 300);
  scene["bake"]["extent"] = {{"min", {6000, 0}}, {"max", {7000, 300}}};
  EXPECT_THAT(failure(scene), ElementsAre(HasSubstr("/bake/extent: misses the terrains")));
}

TEST_F(Open, PutsPointsOverTheGround) {
  auto scene = minimal();
  scene["operations"] = json::parse(R"([
    {"op": "union", "tree": {"type": "sphere", "radius": 5,
                             "center": {"xy": [604, 404], "ground": 2.5}}},
    {"type": "tunnel", "radius": 9, "smooth": false,
     "path": [{"uv": [0.5, 0.25], "ground": -4}, [1, 2, 3]]}])");
  const auto made = opened(scene);
  const auto& ball = std::get<tree::Sphere>(made.ground.steps[0].tree.value);
  EXPECT_EQ(ball.center.form, tree::Point::Form::fixed);
  EXPECT_EQ(ball.center.value, (Vec3{604, 404, ground(made, 604, 404) + 2.5}));
  const auto& passage = std::get<tree::Polyline>(made.ground.steps[1].tree.value);
  const auto& box = made.extent;
  const double x = (box.min.x + box.max.x) / 2, y = box.min.y + 0.25 * (box.max.y - box.min.y);
  EXPECT_EQ(passage.points[0].value, (Vec3{x, y, ground(made, x, y) - 4}));
  EXPECT_EQ(passage.points[1].value, (Vec3{1, 2, 3}));
}

TEST_F(Open, NamesThePointThatLiesOverAHole) {
  auto scene = minimal();
  scene["define"] = json::parse(R"({"boulder": {"type": "union", "children": [
      {"type": "sphere", "center": [0, 0, 0], "radius": 3},
      {"type": "sphere", "center": {"xy": [-50, 0], "ground": 0}, "radius": 3}]}})");
  scene["operations"] = json::parse(R"([
    {"op": "union", "tree": {"type": "translate", "by": [0, 0, 9], "child": {"use": "boulder"}}},
    {"type": "curve", "radius": 3, "points": [[0, 0, 0], {"xy": [1500, 500], "ground": 0}]}])");
  EXPECT_THAT(failure(scene), ElementsAre(HasSubstr("/define/boulder/children/1/center: "),
                                          HasSubstr("/operations/1/points/1: ")));
}

TEST_F(Open, QueuesTheOperationsInTheirOrder) {
  auto scene = minimal();
  scene["materials"] = json::parse(R"([{"name": "soft"}, {"name": "hard"}])");
  scene["operations"] = json::parse(R"([
    {"id": "ball", "op": "blend", "material": "hard",
     "tree": {"type": "sphere", "center": [500, 500, 130], "radius": 9}},
    {"type": "cave", "entrance": [500, 500, 90], "direction": [1, 0, 0], "depth": 50, "radius": 8,
     "region": {"type": "altitude", "range": [80, 100]}},
    {"type": "cave", "op": "carve", "entrance": [500, 500, 90], "direction": [1, 0, 0],
     "depth": 50, "radius": 8}])");
  const auto steps = opened(scene).ground.steps;
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].id, "ball");
  EXPECT_EQ(steps[0].where, "/operations/0");
  EXPECT_EQ(steps[0].operation, tree::Operation::blend);
  EXPECT_EQ(steps[0].material, 1);
  EXPECT_EQ(steps[0].region, nullptr);
  EXPECT_EQ(steps[1].operation, tree::Operation::difference);
  EXPECT_EQ(steps[1].material, -1);
  ASSERT_NE(steps[1].region, nullptr);
  EXPECT_EQ(steps[1].region->box.max.z, 100);
  EXPECT_EQ(steps[2].operation, tree::Operation::carve);
}

TEST_F(Open, VariesEverythingRandomWithTheSceneSeed) {
  auto scene = minimal();
  scene["geology"] = {{"type", "strata"}, {"wavelength", 9}, {"seed", 5}};
  scene["operations"] = json::parse(R"([
    {"type": "cave", "entrance": [500, 500, 90], "direction": [1, 0, 0], "depth": 90, "radius": 8},
    {"op": "union", "tree": {"type": "sphere", "center": [500, 500, 130], "radius": 9,
                             "turbulence": {"amplitude": 1, "seed": 3}}}])");
  const auto plain = opened(scene);
  EXPECT_EQ(std::get<tree::Strata>(plain.ground.geology->value).seed, 5U);
  scene["seed"] = 12;
  const auto varied = opened(scene);
  EXPECT_NE(std::get<tree::Strata>(varied.ground.geology->value).seed, 5U);
  EXPECT_NE(std::get<tree::Sphere>(varied.ground.steps[1].tree.value).turbulence.seed, 3U);
  EXPECT_NE(varied.ground.steps[0].tree, plain.ground.steps[0].tree);
  EXPECT_EQ(opened(scene).ground.steps[0].tree, varied.ground.steps[0].tree);
}

TEST_F(Open, TellsOfAnOperationOutsideTheWorld) {
  auto scene = minimal();
  scene["operations"] = json::parse(
      R"([{"type": "sphere", "center": [5000, 0, 0], "radius": 3},
          {"type": "sphere", "center": [500, 500, 400], "radius": 30}])");
  const auto made = opened(scene);
  EXPECT_THAT(made.warnings, ElementsAre(HasSubstr("/operations/0: ")));
  EXPECT_GE(made.extent.max.z, 430);
}

TEST_F(Open, MakesABodyOfEveryTerrain) {
  auto scene = minimal();
  scene["terrains"].push_back(json::parse(
      R"({"id": "island", "dem": "dem.tif", "offset": 300, "falloff": 12,
          "domain": [[600, 300], [700, 300], [700, 400], [600, 400]]})"));
  scene["terrains"].push_back(json::parse(
      R"({"id": "below", "dem": "dem.tif", "offset": 270, "inverted": true,
          "domain": [[600, 300], [700, 300], [700, 400], [600, 400]]})"));
  const auto made = opened(scene);
  ASSERT_EQ(made.ground.bodies.size(), 3U);
  EXPECT_EQ(made.pyramids.size(), 3U);
  EXPECT_EQ(made.ground.bodies[1].falloff, 12);
  EXPECT_EQ(made.ground.bodies[1].domain.size(), 4U);
  EXPECT_TRUE(made.ground.bodies[2].inverted);
  EXPECT_GT(made.extent.max.z, 370);
}

TEST_F(Open, TellsHowFarItIs) {
  auto settings = OpenSettings{.cache = folder() / "fresh", .ingest = {}};
  double last = -1;
  settings.ingest.progress = [&](double part) { last = part; };
  open(minimal(), sources(), settings);
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace hoodoo::scene
