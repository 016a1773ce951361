#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "engine/base/file.hpp"
#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Plan = std::vector<std::array<double, 2>>;

json sea(const char* more = "{}") {
  auto operation = json::parse(R"({"id": "sea", "type": "sea_cliffs", "range": 20, "radius": 10,
                                   "distance": 8})");
  operation.update(json::parse(more));
  return operation;
}

class SeaCliffs : public GrowingTest {
 protected:
  /// Hard rock with a weak layer between 2 and 8 m.
  static json layered(json operation) {
    auto scene = with(std::move(operation));
    scene["geology"] = json::parse(R"j({"type": "expression",
        "formula": "0.9 - 0.8 * clamp(20 * (3 - abs(z - 5)), 0, 1)"})j");
    return scene;
  }
};

TEST_F(SeaCliffs, CarveAroundSeaLevelOnly) {
  const auto scene = grown(with(sea()));
  const auto list = balls(scene);
  ASSERT_GT(list.size(), 100U);
  EXPECT_EQ(counted(scene, "placed"), list.size());
  EXPECT_EQ(counted(scene, "sampled"), counted(scene, "placed") + counted(scene, "too weak"));
  for (const auto& ball : list) {
    EXPECT_LE(std::abs(ball.center.z), 20);
    EXPECT_EQ(ball.radius, 10);
    EXPECT_GT(ball.energy, 0);
    EXPECT_LE(ball.energy, 2);
  }
}

TEST_F(SeaCliffs, ConcentrateInAWeakLayer) {
  const auto scene = grown(layered(sea(R"({"beta": 0})")));
  double weak = 0, hard = 0;
  std::size_t of_weak = 0, of_hard = 0;
  for (const auto& ball : balls(scene)) {
    const bool in = ball.center.z > 2 && ball.center.z < 8;
    (in ? weak : hard) += static_cast<double>(ball.energy);
    ++(in ? of_weak : of_hard);
  }
  ASSERT_GT(of_weak, 20U);
  const double per_weak = weak / static_cast<double>(of_weak);
  const double per_hard = hard / static_cast<double>(std::max<std::size_t>(of_hard, 1));
  EXPECT_GT(per_weak, 4 * per_hard);
  EXPECT_GT(weak, 2 * hard);
}

TEST_F(SeaCliffs, LeaveTheHardestRockWithoutBetaAlone) {
  auto scene = with(sea(R"({"beta": 0})"));
  scene["geology"] = json::parse(R"({"type": "expression", "formula": "1"})");
  EXPECT_TRUE(balls(grown(scene)).empty());
  scene["operations"][0]["beta"] = 0.5;
  const auto list = balls(grown(scene));
  ASSERT_FALSE(list.empty());
  for (const auto& ball : list) EXPECT_LE(ball.energy, 1.0F);  // e <= beta, energy 2
}

TEST_F(SeaCliffs, WorkOnWhatTheLastStepLeft) {
  const auto scene = grown(with(sea(R"({"steps": 3})")));
  ASSERT_EQ(scene.ground.steps.size(), 3U);
  const auto& record = scene.grown.front();
  EXPECT_EQ(record.first_step, 0U);
  EXPECT_EQ(record.steps, 3U);
  const auto deepest = [&](std::size_t step) {  // below the terrain [m]
    double most = 0;
    const auto& set = std::get<tree::PointSet>(scene.ground.steps[step].tree.value);
    for (const auto& ball : set.balls.list()) {
      const auto& c = ball.center;
      const auto window = scene.pyramids[0]->window(0, Box{c, c});
      most = std::max(most, window.height(c.x, c.y) - c.z);
    }
    return most;
  };
  EXPECT_GT(deepest(2), deepest(0) + 2);
}

TEST_F(SeaCliffs, AreTheSameForAnyThreadsAndOthersForAnotherSeed) {
  const auto one = balls(grown(with(sea()), 1));
  EXPECT_EQ(one, balls(grown(with(sea()), 2)));
  EXPECT_NE(one, balls(grown(with(sea(R"({"seed": 1})")))));
  auto other = with(sea());
  other["seed"] = 12;
  EXPECT_NE(one, balls(grown(other)));
}

TEST_F(SeaCliffs, ChangeOnlyWhereTheRegionDoes) {
  const auto whole = balls(grown(with(sea())));
  const auto part = balls(grown(
      with(sea(R"({"region": {"type": "box", "min": [0, 0, -100], "max": [1000, 400, 100]}})"))));
  std::vector<tree::Ball> expected;
  for (const auto& ball : whole) {
    if (ball.center.y <= 400) expected.push_back(ball);
  }
  ASSERT_FALSE(expected.empty());
  EXPECT_LT(expected.size(), whole.size());
  EXPECT_EQ(part, expected);
}

TEST_F(SeaCliffs, RefuseWhatIsOutOfRange) {
  const auto list = texts(problems(with(sea(R"({"range": -1, "beta": 2, "steps": 0})"))));
  EXPECT_EQ(list, (std::vector<std::string>{"/operations/0/range: must be in (0, 100000] m, got -1",
                                            "/operations/0/steps: must be in [1, 20], got 0",
                                            "/operations/0/beta: must be in [0, 1], got 2"}));
}

TEST_F(SeaCliffs, LieOnTheDiskWhereTheyAreMany) {
  OpenSettings settings{.cache = folder() / "cache", .ingest = {}};
  settings.ball_memory = 1000;
  const auto scene = open(with(sea()), sources(), settings);
  const auto& set = std::get<tree::PointSet>(scene.ground.steps[0].tree.value);
  EXPECT_TRUE(set.balls.in_file());
  EXPECT_EQ(scene.ball_files.size(), 2U);  // with its lock
  EXPECT_EQ(set.balls.list(), balls(grown(with(sea()))));
}

/// Points of a shapefile (ESRI Shapefile Technical Description, 1998) in the scene frame.
Plan mapped(const fs::path& file, const dem::Frame& frame) {
  const auto bytes = read_file(file, 1 << 20);
  Plan points;
  constexpr std::size_t header = 100, record = 28, before = 12;
  for (auto at = header; at + record <= bytes.size(); at += record) {
    std::array<double, 2> p{};
    std::memcpy(p.data(), bytes.data() + at + before, sizeof p);
    points.push_back({p[0] - frame.origin_x, p[1] - frame.origin_y});
  }
  return points;
}

double nearest(const Plan& points, double x, double y) {
  double least = 1e9;
  for (const auto& p : points) least = std::min(least, std::hypot(p[0] - x, p[1] - y));
  return least;
}

/// Cliffs of California by lidar, and their bases and tops as mapped by hand
/// (Swirad, Young 2022, Geosci. Model Dev. 15, 1499).
class LidarCliffs : public testing::TestWithParam<std::string> {};

TEST_P(LidarCliffs, AreWhereTheSeaWorks) {
  const char* data = std::getenv("HOODOO_TEST_DATA");
  const auto dem = fs::path(data == nullptr ? "" : data) / "dem" /
                   ("seacliff_" + GetParam() + "_1m_utm10n_f32_nodata.tif");
  if (!fs::exists(dem)) GTEST_SKIP() << "HOODOO_TEST_DATA has no " << dem.filename();
  const Folder folder;
  const auto stated = json::parse(R"({"hoodoo": 1, "terrains": [{"id": "land", "dem": ")" +
                                  dem.string() + R"("}], "operations": [{"type": "sea_cliffs"}]})");
  const auto scene = open(stated, {folder.path(), {}}, {.cache = folder / "cache", .ingest = {}});
  ASSERT_EQ(scene.ground.steps.size(), 1U);
  const auto oracle = fs::path(data) / "oracle" / ("seacliff_" + GetParam());
  const auto base = mapped(oracle / (GetParam() + "_base_true.shp"), scene.frame);
  auto cliff = mapped(oracle / (GetParam() + "_top_true.shp"), scene.frame);
  ASSERT_GT(base.size(), 100U);
  cliff.insert(cliff.end(), base.begin(), base.end());
  Plan placed;
  for (const auto& ball : std::get<tree::PointSet>(scene.ground.steps[0].tree.value).balls.list()) {
    placed.push_back({ball.center.x, ball.center.y});
  }

  std::size_t found = 0, right = 0;
  for (const auto& [x, y] : base) found += nearest(placed, x, y) <= 10 ? 1 : 0;
  for (const auto& [x, y] : placed) right += nearest(cliff, x, y) <= 25 ? 1 : 0;
  RecordProperty("base_found", static_cast<int>(1000 * found / base.size()));
  RecordProperty("placed_right", static_cast<int>(1000 * right / placed.size()));
  EXPECT_GE(static_cast<double>(found), 0.9 * static_cast<double>(base.size()));
  EXPECT_GE(static_cast<double>(right), 0.8 * static_cast<double>(placed.size()));
}

INSTANTIATE_TEST_SUITE_P(Aoi, LidarCliffs, testing::Values("aoi4", "aoi8"),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace hoodoo::scene
