#include <gmock/gmock.h>

#include "tests/engine/dem/written_tiff.hpp"
#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

/// A plain with two walls 40 m high across it: 16 m thick around y = 100, 40 m around y = 300.
class Arches : public GrowingTest {
 protected:
  static constexpr int side = 200;
  static constexpr double pixel = 2;

  static void SetUpTestSuite() {
    GrowingTest::SetUpTestSuite();
    std::vector<float> samples;
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double y = (side - j - 0.5) * pixel;
        const double off = std::min(std::abs(y - 100) - 8, std::abs(y - 300) - 20);
        samples.push_back(static_cast<float>(40 * std::clamp(1 - off / 6, 0.0, 1.0)));
      }
    }
    dem::TiffOptions options;
    options.scale = {pixel, pixel, 0};
    options.ties = {0, 0, 0, 400'000, 4'100'000, 0};
    options.keys = dem::utm(32612);
    dem::write_tiff(folder() / "walls.tif", side, side, samples, options);
  }
  static json arches(const char* more = "{}") {
    auto operation = json::parse(R"({"type": "arches", "width": 40, "span": 10, "height": 16,
                                     "roof": 6, "distance": 40, "beta": 0.5})");
    operation.update(json::parse(more));
    auto scene = with(operation);
    scene["terrains"][0]["dem"] = "walls.tif";
    return scene;
  }
  static std::vector<tree::Node> openings(const Scene& scene) {
    if (scene.ground.steps.empty()) return {};
    const auto& all = scene.ground.steps.front().tree;
    if (std::holds_alternative<tree::Union>(all.value)) return children_of(all);
    return {all};
  }
  static Vec3 middle(const tree::Node& opening) {
    const auto& tube = std::get<tree::Segment>(opening.children.front().value);
    return (tube.from.value + tube.to.value) * 0.5;
  }
};

TEST_F(Arches, LeadRightThroughThinWallsAlone) {
  const auto scene = grown(arches());
  const auto list = openings(scene);
  ASSERT_GT(list.size(), 3U);
  EXPECT_EQ(counted(scene, "placed"), list.size());
  EXPECT_GT(counted(scene, "too thick"), 0U);
  const auto& window = *scene.pyramids[0];
  for (const auto& opening : list) {
    const Vec3 at = middle(opening);
    EXPECT_NEAR(at.y, 100, 8);
    for (const auto& part : opening.children) {
      const auto& tube = std::get<tree::Segment>(part.value);
      for (double t = 0; t <= 1; t += 0.05) {
        const Vec3 p = tube.from.value + (tube.to.value - tube.from.value) * t;
        EXPECT_LT(field(scene, p), 0.5F) << p.x << " " << p.y << " " << p.z;
      }
    }
    // Rock over it, up to the crest.
    const double crest = window.window(0, Box{at, at}).height(at.x, at.y);
    EXPECT_GT(field(scene, {at.x, at.y, crest - 4}), 0.5F);
    EXPECT_GT(crest, at.z + 6);
  }
}

TEST_F(Arches, KeepTheirDistance) {
  const auto list = openings(grown(arches()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(length(middle(list[i]) - middle(list[k])), 40);
  }
}

TEST_F(Arches, LieWhereTheRockIsWeak) {
  auto scene = arches(R"({"beta": 0, "distance": 12, "span": 6, "height": 10})");
  scene["geology"] =
      json::parse(R"j({"type": "expression", "formula": "1 - 0.9 * clamp(x - 200, 0, 1)"})j");
  const auto list = openings(grown(scene));
  ASSERT_GT(list.size(), 5U);
  for (const auto& opening : list) EXPECT_GT(middle(opening).x, 200);
}

// The chance is e(rho, s) with beta = 0, which is in proportion to 1 - rho.
TEST_F(Arches, AreMoreInWeakerRock) {
  std::vector<double> likely;
  for (const char* rho : {"0.1", "0.7"}) {
    auto scene = arches(R"({"beta": 0, "span": 5})");
    scene["geology"] = {{"type", "expression"}, {"formula", rho}};
    const auto made = grown(scene);
    const auto walls = counted(made, "sampled") - counted(made, "too thick");
    likely.push_back(static_cast<double>(walls - counted(made, "by chance")));
  }
  EXPECT_GT(likely[1], 50);
  EXPECT_NEAR(likely[0] / likely[1], 3, 0.6);
}

TEST_F(Arches, AreTheSameForAnyThreadsAndOthersForAnotherSeed) {
  const auto one = trees(grown(arches(), 1));
  EXPECT_EQ(one, trees(grown(arches(), 2)));
  EXPECT_NE(one, trees(grown(arches(R"({"seed": 1})"))));
}

TEST_F(Arches, ChangeOnlyWhereTheRegionDoes) {
  std::vector<tree::Node> expected;
  const auto whole = openings(grown(arches()));
  for (const auto& opening : whole) {
    if (middle(opening).x < 200) expected.push_back(opening);
  }
  ASSERT_FALSE(expected.empty());
  EXPECT_LT(expected.size(), whole.size());
  EXPECT_EQ(expected, openings(grown(arches(
                          R"({"region": {"type": "box", "min": [-9, -9, -100],
                                         "max": [200, 409, 100], "feather": 0}})"))));
}

TEST_F(Arches, RefuseWhatIsOutOfRange) {
  EXPECT_EQ(texts(problems(arches(R"({"width": 0, "probability": 1.5, "beta": -1})"))),
            (std::vector<std::string>{"/operations/0/width: must be in (0, 10000] m, got 0",
                                      "/operations/0/probability: must be in [0, 1], got 1.5",
                                      "/operations/0/beta: must be in [0, 1], got -1"}));
  EXPECT_THAT(places_of(problems(arches(R"({"turbulence": {"amplitude": 30}})"))),
              testing::ElementsAre("/operations/0/turbulence/amplitude"));
}

}  // namespace
}  // namespace hoodoo::scene
