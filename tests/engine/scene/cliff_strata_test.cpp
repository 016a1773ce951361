#include <gmock/gmock.h>

#include <cmath>

#include "tests/engine/dem/written_tiff.hpp"
#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// A cliff of 60 degrees from 0 to 120 m, level ground before and behind it.
class CliffStrata : public GrowingTest {
 protected:
  static constexpr int side = 120;
  static constexpr double pixel = 2, foot = 80, steep = 1.7320508;  // of the slope

  static void SetUpTestSuite() {
    GrowingTest::SetUpTestSuite();
    std::vector<float> samples;
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double x = (i + 0.5) * pixel;
        samples.push_back(static_cast<float>(std::clamp(steep * (x - foot), 0.0, 120.0)));
      }
    }
    dem::TiffOptions options;
    options.scale = {pixel, pixel, 0};
    options.ties = {0, 0, 0, 400'000, 4'100'000, 0};
    options.keys = dem::utm(32612);
    dem::write_tiff(folder() / "cliff.tif", side, side, samples, options);
  }
  static json on_cliff(const char* more, const char* rho) {
    auto operation = json::parse(R"({"type": "cliff_strata", "depth": 4, "distance": 3,
                                     "bands": {"contrast": 0}})");
    operation.update(json::parse(more));
    auto scene = with(operation);
    scene["terrains"][0]["dem"] = "cliff.tif";
    scene["terrains"][0]["falloff"] = 24;
    scene["geology"] = {{"type", "expression"}, {"formula", rho}};
    return scene;
  }
  /// How far the face lies behind the terrain's, along the normal [m].
  static double retreat(const Scene& scene, double y, double z) {
    const Vec3 in{0.8660254, 0, -0.5}, at{foot + z / steep, y, z};
    double gone = 0;
    while (gone < 20 && field(scene, at + in * gone) < 0.5F) gone += 0.1;
    return gone;
  }
  static std::vector<tree::Ball> samples(const Scene& scene) {
    if (scene.ground.steps.empty()) return {};
    const auto& erosion = scene.ground.steps.front().tree;
    return std::get<tree::PointSet>(erosion.children.at(1).value).balls.list();
  }
};

TEST_F(CliffStrata, WearTheSoftestRockByTheDepth) {
  const auto soft = grown(on_cliff("{}", "0"));
  EXPECT_GT(counted(soft, "placed"), 200U);
  EXPECT_EQ(counted(soft, "shallower than asked"), 0U);
  double sum = 0;
  for (double z = 30; z <= 90; z += 4) {
    sum += retreat(soft, 120, z);
    EXPECT_NEAR(retreat(soft, 120, z), 4, 1.5) << z;
  }
  EXPECT_NEAR(sum / 16, 4, 0.6);
  const auto hard = grown(on_cliff("{}", "1"));
  for (double z = 30; z <= 90; z += 4) EXPECT_LT(retreat(hard, 120, z), 0.15) << z;
}

TEST_F(CliffStrata, LeaveHardLayersStandingOut) {
  const auto scene = grown(on_cliff("{}", "clamp(6 * sin(z / 5), 0, 1)"));
  std::vector<double> hard, soft;
  for (double z = 30; z <= 90; z += 0.5) {
    // The rock of a place on the face is that half the depth behind it.
    const double s = std::sin(z / 5);
    if (s > 0.9) hard.push_back(retreat(scene, 120, z));
    if (s < -0.9) soft.push_back(retreat(scene, 120, z));
  }
  EXPECT_LT(*std::ranges::max_element(hard), *std::ranges::min_element(soft));
  EXPECT_GT(*std::ranges::min_element(soft), 2);
}

TEST_F(CliffStrata, WorkOnSteepSlopesAlone) {
  const auto before = opened(on_cliff(R"({"depth": 1e-9})", "0"));
  const auto after = grown(on_cliff("{}", "0"));
  constexpr double reach = 11;  // twice the depth and a distance
  EXPECT_EQ(lost(before, after, {{0, 0, -20}, {foot - reach, 240, 20}}, 4), 0U);
  EXPECT_EQ(lost(before, after, {{foot + 120 / steep + reach, 0, 100}, {240, 240, 130}}, 4), 0U);
  EXPECT_GT(lost(before, after, {{foot, 20, 20}, {foot + 60, 220, 100}}, 4), 200U);
  EXPECT_TRUE(samples(grown(on_cliff(R"({"steepness": 65})", "0"))).empty());
}

TEST_F(CliffStrata, AddBandsToTheGeology) {
  const auto deviation = [](const Scene& scene) {
    double sum = 0, squares = 0;
    for (double z = 30; z < 90; z += 0.5) {
      const double r = retreat(scene, 120, z);
      sum += r;
      squares += r * r;
    }
    return std::sqrt(squares / 120 - sum * sum / 120 / 120);
  };
  const double plain = deviation(grown(on_cliff("{}", "0.5")));
  const double ledges = deviation(grown(on_cliff(R"({"bands": {"contrast": 1}})", "0.5")));
  EXPECT_GT(ledges, 2 * plain);
}

TEST_F(CliffStrata, SayWhereTheyCannotGoSoDeep) {
  const auto scene = grown(on_cliff(R"({"depth": 30, "distance": 6})", "0"));
  EXPECT_GT(counted(scene, "shallower than asked"), counted(scene, "placed") / 2);
}

TEST_F(CliffStrata, AreTheSameForAnyThreadsAndOthersForAnotherSeed) {
  const auto one = trees(grown(on_cliff("{}", "0.5"), 1));
  EXPECT_EQ(one, trees(grown(on_cliff("{}", "0.5"), 2)));
  EXPECT_NE(one, trees(grown(on_cliff(R"({"seed": 1})", "0.5"))));
}

TEST_F(CliffStrata, ChangeOnlyWhereTheRegionDoes) {
  std::vector<tree::Ball> expected;
  const auto whole = samples(grown(on_cliff("{}", "0.5")));
  for (const auto& ball : whole) {
    if (ball.center.y <= 100) expected.push_back(ball);
  }
  ASSERT_FALSE(expected.empty());
  EXPECT_LT(expected.size(), whole.size());
  const auto part = samples(grown(on_cliff(
      R"({"region": {"type": "box", "min": [-9, -9, -100], "max": [249, 100, 200], "feather": 0}})",
      "0.5")));
  EXPECT_EQ(part, expected);
}

TEST_F(CliffStrata, RefuseWhatIsOutOfRange) {
  EXPECT_EQ(texts(problems(
                on_cliff(R"({"depth": 0, "steepness": 120, "bands": {"thickness": -1}})", "0.5"))),
            (std::vector<std::string>{
                "/operations/0/depth: must be in (0, 1000] m, got 0",
                "/operations/0/steepness: must be in [0, 90] deg, got 120",
                "/operations/0/bands/thickness: must be in (0, 100000] m, got -1"}));
}

}  // namespace
}  // namespace hoodoo::scene
