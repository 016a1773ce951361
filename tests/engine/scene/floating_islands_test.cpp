#include <gmock/gmock.h>

#include <cmath>

#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

class FloatingIslands : public GrowingTest {
 protected:
  static json islands(const char* more = "{}", const char* rho = "0.5") {
    auto operation = json::parse(R"({"type": "floating_islands", "least_radius": 60,
        "most_radius": 90, "distance": 200, "least_height": 50, "most_height": 150, "caves": 1,
        "cave_radius": 6})");
    operation.update(json::parse(more));
    auto scene = with(operation);
    scene["geology"] = {{"type", "expression"}, {"formula", rho}};
    return scene;
  }
  /// Middles and radii.
  static std::vector<generator::Mark> marks(const Scene& scene) {
    for (const auto& [name, list] : scene.grown.front().marks) {
      if (name == "islands") return list;
    }
    return {};
  }
  /// Where rock lies over a place, beginning above the ground, every 2 m.
  static std::vector<double> rock_over(const Scene& scene, double x, double y) {
    const Box box{{x, y, 0}, {x, y, 700}};
    const double ground = scene.pyramids[0]->window(0, box).height(x, y);
    const auto inside = solid(scene, box, 2);
    std::vector<double> rock;
    for (std::size_t i = 0; i < inside.size(); ++i) {
      const double z = 2 * static_cast<double>(i);
      if (inside[i] && z > ground + 4) rock.push_back(z);
    }
    return rock;
  }
  static Box around(const generator::Mark& mark) {
    const double r = mark.value;
    return {mark.at - Vec3{r, r, 2 * r}, mark.at + Vec3{r, r, r}};
  }
};

TEST_F(FloatingIslands, FloatAtTheStatedHeights) {
  const auto scene = grown(islands(R"({"caves": 0, "erosion": 0})"));
  const auto list = marks(scene);
  ASSERT_GT(list.size(), 3U);
  EXPECT_EQ(counted(scene, "placed"), list.size());
  EXPECT_EQ(counted(scene, "sampled"), list.size() + counted(scene, "over the edge or a hole"));
  for (const auto& mark : list) {
    EXPECT_GE(mark.value, 60);
    EXPECT_LE(mark.value, 90);
    double lowest = 1e9, highest_ground = -1e9;
    std::size_t thick = 0;
    for (double a = -1; a <= 1; a += 0.125) {
      for (double b = -1; b <= 1; b += 0.125) {
        if (a * a + b * b > 1) continue;
        const double x = mark.at.x + a * mark.value, y = mark.at.y + b * mark.value;
        const Vec3 p{x, y, 0};
        highest_ground =
            std::max(highest_ground, scene.pyramids[0]->window(0, Box{p, p}).height(x, y));
        const auto rock = rock_over(scene, x, y);
        if (rock.empty()) continue;
        lowest = std::min(lowest, rock.front());
        thick = std::max(thick, rock.size());
      }
    }
    EXPECT_GT(lowest, highest_ground + 50 - 5);
    EXPECT_LT(lowest, highest_ground + 150 + 25);
    EXPECT_GT(2 * static_cast<double>(thick), 0.4 * mark.value);
  }
}

TEST_F(FloatingIslands, StayWithinTheirCircle) {
  const auto scene = grown(islands(R"({"caves": 0, "erosion": 0})"));
  for (const auto& mark : marks(scene)) {
    for (int k = 0; k < 12; ++k) {
      const double angle = k * 0.5236, far = mark.value + 2;
      EXPECT_TRUE(
          rock_over(scene, mark.at.x + far * std::cos(angle), mark.at.y + far * std::sin(angle))
              .empty());
    }
  }
}

TEST_F(FloatingIslands, EndNearTheirCircle) {
  const auto scene = grown(islands());
  const auto list = marks(scene);
  const auto bodies = children_of(scene.ground.steps.front().tree);
  ASSERT_EQ(bodies.size(), list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto box = tree::support(bodies[i]).influence;
    EXPECT_LT(box.max.x, list[i].at.x + 1.5 * list[i].value);
    EXPECT_LT(box.max.z, list[i].at.z + list[i].value);
    EXPECT_GT(box.min.z, list[i].at.z - 2.5 * list[i].value);
    EXPECT_GE(scene.extent.max.z, list[i].at.z);
  }
}

TEST_F(FloatingIslands, AreWornWhereTheirRockIsWeak) {
  const auto bare = grown(islands(R"({"caves": 0, "erosion": 0})"));
  const Box box = around(marks(bare).front());
  std::vector<std::size_t> gone;
  for (const char* rho : {"1", "0.5", "0"}) {
    gone.push_back(
        lost(bare, grown(islands(R"({"caves": 0, "bands": {"contrast": 0}})", rho)), box, 4));
  }
  EXPECT_EQ(gone[0], 0U);
  EXPECT_GT(gone[1], 50U);
  EXPECT_GT(static_cast<double>(gone[2]), 1.5 * static_cast<double>(gone[1]));
}

TEST_F(FloatingIslands, HaveCavesInWeakRockAlone) {
  EXPECT_TRUE(balls(grown(islands(R"({"rho_0": 0.4})"))).empty());
  const auto scene = grown(islands());
  const auto list = balls(scene);
  EXPECT_GT(list.size(), 50U);
  EXPECT_EQ(counted(scene, "cave balls"), list.size());
  const auto islands_of = marks(scene);
  for (const auto& ball : list) {
    EXPECT_TRUE(std::ranges::any_of(islands_of, [&](const auto& mark) {
      return std::hypot(ball.center.x - mark.at.x, ball.center.y - mark.at.y) < mark.value;
    }));
  }
  const char* halves = "0.3 + 0.6 * clamp(x - 500, 0, 1)";
  for (const auto& ball : balls(grown(islands("{}", halves)))) EXPECT_LT(ball.center.x, 501);
}

TEST_F(FloatingIslands, AreTheSameForAnyThreadsAndOthersForAnotherSeed) {
  const auto one = trees(grown(islands(), 1));
  EXPECT_EQ(one, trees(grown(islands(), 2)));
  EXPECT_NE(one, trees(grown(islands(R"({"seed": 1})"))));
}

TEST_F(FloatingIslands, ChangeOnlyWhereTheRegionDoes) {
  const auto whole = grown(islands());
  const auto part = grown(islands(R"({"region": {"type": "box", "min": [0, 0, -100],
                                      "max": [1000, 500, 900], "feather": 0}})"));
  std::vector<tree::Node> expected;
  const auto middles = marks(whole);
  const auto all = children_of(whole.ground.steps.front().tree);
  ASSERT_EQ(all.size(), middles.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (middles[i].at.y < 500) expected.push_back(all[i]);
  }
  ASSERT_GT(expected.size(), 1U);
  EXPECT_LT(expected.size(), all.size());
  EXPECT_EQ(children_of(part.ground.steps.front().tree), expected);
  std::vector<tree::Ball> caves;
  for (const auto& ball : balls(whole)) {
    const auto near = std::ranges::min_element(middles, {}, [&](const auto& mark) {
      return std::hypot(ball.center.x - mark.at.x, ball.center.y - mark.at.y);
    });
    if (near->at.y < 500) caves.push_back(ball);
  }
  EXPECT_EQ(balls(part), caves);
}

TEST_F(FloatingIslands, RefuseWhatIsOutOfRange) {
  EXPECT_EQ(texts(problems(islands(R"({"rim": 0, "caves": -1})"))),
            (std::vector<std::string>{"/operations/0/rim: must be in [0.01, 10] radii, got 0",
                                      "/operations/0/caves: must be in [0, 100], got -1"}));
  EXPECT_EQ(texts(problems(islands(R"({"least_radius": 100, "least_height": 200})"))),
            (std::vector<std::string>{
                "/operations/0/least_radius: must be at most \"most_radius\", 90 m, got 100",
                "/operations/0/least_height: must be at most \"most_height\", 150 m, got 200"}));
}

}  // namespace
}  // namespace hoodoo::scene
