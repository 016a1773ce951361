#include <cmath>

#include "tests/engine/dem/written_tiff.hpp"
#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// A gorge 20 m deep that turns through half a circle of 120 m around the middle of its west side:
/// the outer bank lies beyond that radius, the inner one within it.
class RiverCanyon : public GrowingTest {
 protected:
  static constexpr int side = 200;
  static constexpr double pixel = 2, middle = 200, bend = 120, low = 30;

  static void SetUpTestSuite() {
    GrowingTest::SetUpTestSuite();
    std::vector<float> samples;
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double x = (i + 0.5) * pixel, y = (side - j - 0.5) * pixel - middle;
        const double off = std::abs(std::hypot(x, y) - bend);
        const double along = std::atan2(y, x);  // falls as it goes round
        const double wall = std::clamp((off - 6) / 14, 0.0, 1.0);
        samples.push_back(static_cast<float>(low + 4 * along + 20 * wall + 0.01 * off));
      }
    }
    dem::TiffOptions options;
    options.scale = {pixel, pixel, 0};
    options.ties = {0, 0, 0, 400'000, 4'100'000, 0};
    options.keys = dem::utm(32612);
    dem::write_tiff(folder() / "gorge.tif", side, side, samples, options);
  }
  static json scene_with(const char* more = "{}") {
    auto operation = json::parse(R"({"id": "river", "type": "river_canyon", "drainage": 4000,
        "percentile": 99, "stress": 0.01, "radius": 4, "distance": 3, "banks": 20, "flood": 15})");
    operation.update(json::parse(more));
    auto scene = with(operation);
    scene["terrains"][0]["dem"] = "gorge.tif";
    return scene;
  }
  struct Sides {
    double outer = 0, inner = 0;  // energy of balls farther and nearer than the bed
  };
  /// On the part of the bend away from the terrain's edge.
  static Sides sides(const std::vector<tree::Ball>& balls) {
    Sides sum;
    for (const auto& ball : balls) {
      if (ball.center.x < 40) continue;
      const double r = std::hypot(ball.center.x, ball.center.y - middle);
      (r > bend ? sum.outer : sum.inner) += static_cast<double>(ball.energy);
    }
    return sum;
  }
};

TEST_F(RiverCanyon, WorksOnTheBanksOfTheRiver) {
  const auto scene = grown(scene_with());
  const auto list = balls(scene);
  ASSERT_GT(list.size(), 100U);
  EXPECT_EQ(counted(scene, "placed"), list.size());
  EXPECT_GT(counted(scene, "bed cells"), 50U);
  std::size_t near = 0;
  for (const auto& ball : list) {
    const double r = std::hypot(ball.center.x, ball.center.y - middle);
    near += std::abs(r - bend) < 30 ? 1 : 0;
    EXPECT_LE(ball.energy, 2);
  }
  EXPECT_GT(near * 10, list.size() * 9);
}

TEST_F(RiverCanyon, WorksHarderOnOuterBanks) {
  const auto even = sides(balls(grown(scene_with(R"({"outer": 0})"))));
  const auto bent = sides(balls(grown(scene_with(R"({"outer": 1})"))));
  ASSERT_GT(even.inner, 0);
  EXPECT_LT(even.outer / even.inner, 2);
  EXPECT_GT(bent.outer / bent.inner, 1.3 * (even.outer / even.inner));
}

// Samples do not depend on the rock, so that balls can be compared one by one.
TEST_F(RiverCanyon, ConcentratesInAWeakLayer) {
  auto scene = scene_with(R"({"beta": 0, "threshold": 0})");
  scene["geology"] = json::parse(R"({"type": "expression", "formula": "0.9"})");
  const auto hard = balls(grown(scene));
  scene["geology"] = json::parse(R"j({"type": "expression",
      "formula": "0.9 - 0.8 * clamp(20 * (4 - abs(z - 36)), 0, 1)"})j");
  const auto layered = balls(grown(scene));
  ASSERT_EQ(hard.size(), layered.size());
  std::size_t weak = 0;
  for (std::size_t i = 0; i < hard.size(); ++i) {
    ASSERT_EQ(hard[i].center, layered[i].center);
    const double off = std::abs(hard[i].center.z - 36);
    if (off > 4.01) {
      EXPECT_EQ(hard[i].energy, layered[i].energy);
    }
    if (off > 3.9) continue;
    EXPECT_NEAR(layered[i].energy, 9 * hard[i].energy, 1e-5);  // (1 - 0.1) / (1 - 0.9)
    ++weak;
  }
  EXPECT_GT(weak, 20U);
}

TEST_F(RiverCanyon, IsTheSameForAnyThreadsAndAnotherForAnotherSeed) {
  const auto one = balls(grown(scene_with(), 1));
  EXPECT_EQ(one, balls(grown(scene_with(), 2)));
  EXPECT_NE(one, balls(grown(scene_with(R"({"seed": 1})"))));
}

TEST_F(RiverCanyon, ChangesOnlyWhereTheRegionDoes) {
  std::vector<tree::Ball> expected;
  for (const auto& ball : balls(grown(scene_with()))) {
    if (ball.center.y <= 190) expected.push_back(ball);
  }
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(
      expected,
      balls(grown(scene_with(
          R"({"region": {"type": "box", "min": [-9, -9, -100], "max": [409, 190, 100], "feather": 0}})"))));
}

TEST_F(RiverCanyon, NeedsRoomForTheWatersWay) {
  OpenSettings settings{.cache = folder() / "cache", .ingest = {}};
  settings.ingest.memory = 1 << 20;
  try {
    open(scene_with(), sources(), settings);
    FAIL() << "40,000 cells take more than 1 MiB";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
    EXPECT_EQ(error.problems.front().where, "/operations/0");
  }
}

}  // namespace
}  // namespace hoodoo::scene
