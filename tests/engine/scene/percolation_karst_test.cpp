#include <gmock/gmock.h>

#include "engine/tree/balls.hpp"
#include "engine/tree/nodes/points.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A weak layer about z = 60 between hard ones, under the sample's plateau.
class PercolationKarst : public SceneTest {
 protected:
  static json scene(const json& more = json::object()) {
    auto made = minimal();
    made["geology"] = json::parse(R"json({"type": "expression",
        "formula": "0.1 + 0.8 * clamp((abs(z - 60) - 8) * 0.5, 0, 1)"
  })json");
    auto one = json::parse(R"({"type": "percolation_karst", "id": "karst", "sinks": false,
        "seeds": [[700, 500, 60], [850, 700, 60]], "upward": 0.3, "count": 400, "cover": 0})");
    one.update(more);
    made["operations"] = json::array({one});
    return made;
  }
  static Scene grown(const json& stated, int threads = 1) {
    OpenSettings settings;
    settings.cache = folder() / "cache";
    settings.ingest.threads = threads;
    settings.keep_marks = true;
    return open(stated, sources(), settings);
  }
  static std::vector<tree::Ball> balls(const Scene& scene) {
    if (scene.ground.steps.empty()) return {};
    return std::get<tree::PointSet>(scene.ground.steps[0].tree.value).balls.list();
  }
};

TEST_F(PercolationKarst, StaysInTheWeakLayer) {
  const auto all = balls(grown(scene()));
  ASSERT_GT(all.size(), 200U);
  const auto inside = std::ranges::count_if(
      all, [](const auto& ball) { return std::abs(ball.center.z - 60) < 9.5; });
  EXPECT_GE(static_cast<double>(inside), 0.9 * static_cast<double>(all.size()));
}

TEST_F(PercolationKarst, IsTheSameOnOneThreadAndOnTwo) {
  const json more{{"cliffs", 60}, {"sinks", true}};
  EXPECT_EQ(balls(grown(scene(more), 1)), balls(grown(scene(more), 2)));
}

TEST_F(PercolationKarst, EntersAtCliffs) {
  const auto made = grown(scene({{"cliffs", 60}, {"seeds", json::array()}}));
  const auto& counts = made.grown.front().counts;
  const auto on =
      std::ranges::find(counts, "places on cliffs", &std::pair<std::string, std::uint64_t>::first);
  ASSERT_NE(on, counts.end());
  EXPECT_GT(on->second, 5U);
  EXPECT_GT(balls(made).size(), 20U);
}

TEST_F(PercolationKarst, IsAnotherOfAnotherSeed) {
  EXPECT_NE(balls(grown(scene())), balls(grown(scene({{"seed", 1}}))));
}

TEST_F(PercolationKarst, OfARegionChangesOnlyWhatLiesInReach) {
  const auto all = balls(grown(scene({{"length", 60}})));
  const json region{{"type", "box"}, {"min", {600, 400, 0}}, {"max", {780, 600, 200}}};
  const auto part = balls(grown(scene({{"length", 60}, {"region", region}})));
  const auto near_first = [](const tree::Ball& ball) { return ball.center.y < 600; };
  std::vector<tree::Ball> expected;
  std::ranges::copy_if(all, std::back_inserter(expected), near_first);
  ASSERT_GT(expected.size(), 20u);
  ASSERT_LT(expected.size(), all.size());
  EXPECT_EQ(part, expected);
}

TEST_F(PercolationKarst, ListsItsGraph) {
  const auto made = grown(scene());
  auto record = made.grown.at(0);
  const auto nodes = record.list("nodes").size();
  EXPECT_EQ(nodes, balls(made).size());
  EXPECT_EQ(record.edges_of("nodes").size(), nodes - record.list("starts").size());
  for (const auto& edge : record.edges_of("nodes")) EXPECT_LT(edge.from, edge.to);
}

TEST_F(PercolationKarst, RefusesWrongValues) {
  const auto wrong = texts(problems(scene({{"radius", -1}, {"beta", 2}})));
  ASSERT_EQ(wrong.size(), 2u);
  EXPECT_THAT(wrong, testing::Contains(HasSubstr("/operations/0/radius: must be")));
  EXPECT_THAT(wrong, testing::Contains(HasSubstr("/operations/0/beta: must be in [0, 1]")));
  EXPECT_THAT(texts(problems(scene({{"step", 2}, {"exclusion", 4}}))),
              testing::ElementsAre("/operations/0/exclusion: must be below twice the step = 4 m, "
                                   "got 4"));
}

}  // namespace
}  // namespace hoodoo::scene
