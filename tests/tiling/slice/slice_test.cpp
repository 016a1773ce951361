#include "tiling/slice/slice.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/base/random.hpp"
#include "engine/scene/sample.hpp"
#include "engine/tree/node.hpp"
#include "tiling/slice/land.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

class Slices : public testing::Test {
 protected:
  Slices() : folder_(fs::temp_directory_path() / ("hoodoo-slice-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    scene::SampleDem sample;
    sample.pixels = 200;
    sample.spacing = 4;
    scene::write_sample_dem(folder_ / "dem.tif", sample);
  }
  ~Slices() override { fs::remove_all(folder_); }

  scene::Scene open(double radius) const {
    const json text = {{"hoodoo", 1},
                       {"terrains", {{{"id", "land"}, {"dem", "dem.tif"}}}},
                       {"operations",
                        {{{"op", "difference"},
                          {"tree",
                           {{"type", "sphere"},
                            {"center", {{"xy", {100, 100}}, {"ground", 0}}},
                            {"radius", radius},
                            {"falloff", 8}}}}}},
                       {"bake", {{"tile_cells", 64}}}};
    scene::OpenSettings settings;
    settings.cache = folder_ / "cache";
    return scene::open(text, {folder_, {}}, settings);
  }
  static plan::Lattice lattice_of(const scene::Scene& scene) {
    return {scene.spacing, dem::step_of(scene.spacing), scene.bake.tile_cells};
  }

  fs::path folder_;
};

}  // namespace

TEST_F(Slices, ChangeExactlyForTheTilesAnEditReaches) {
  const auto small = open(20), large = open(25);
  const auto lattice = lattice_of(small);
  EXPECT_NE(slice::cut(small, lattice, {0, 0, 0}).hash(),
            slice::cut(large, lattice, {0, 0, 0}).hash());
  EXPECT_EQ(slice::cut(small, lattice, {0, 2, 2}).hash(),
            slice::cut(large, lattice, {0, 2, 2}).hash());
}

TEST_F(Slices, LeaveOutAnOperationThatDoesNotReachTheTile) {
  const auto scene = open(20);
  const auto lattice = lattice_of(scene);
  EXPECT_EQ(slice::cut(scene, lattice, {0, 0, 0}).ground.steps.size(), 1U);
  EXPECT_EQ(slice::cut(scene, lattice, {0, 2, 2}).ground.steps.size(), 0U);
}

TEST_F(Slices, HaveBytesThatAreJsonWithoutAnyPath) {
  const auto scene = open(20);
  const auto bytes = slice::cut(scene, lattice_of(scene), {0, 0, 0}).bytes();
  EXPECT_EQ(bytes.find(folder_.filename().string()), std::string::npos);
  EXPECT_EQ(json::parse(bytes)["key"], "0/0/0");
}

TEST_F(Slices, OpenedAsALandGiveNeighboursTheSameNormalsOnTheirBorder) {
  const auto scene = open(20);
  const auto lattice = lattice_of(scene);
  const auto west = slice::cut(scene, lattice, {0, 0, 0}),
             east = slice::cut(scene, lattice, {0, 1, 0});
  slice::Land a(west, scene.pyramids), b(east, scene.pyramids);
  std::vector<slice::StepPoint> points;
  const std::int64_t x = 64L * lattice.units();
  for (std::int64_t i = 0; i < 500; ++i) points.push_back({x, 37 * i, 91 * i});
  EXPECT_EQ(a.normals(points), b.normals(points));
  EXPECT_EQ(a.values(points), b.values(points));
}

TEST_F(Slices, KnowWhichColumnsLieInTheWorld) {
  const auto scene = open(20);
  const auto slice = slice::cut(scene, lattice_of(scene), {0, 0, 0});
  const slice::Land land(slice, scene.pyramids);
  EXPECT_TRUE(land.in_world(10, 10));
  EXPECT_FALSE(land.in_world(-1, 10));
  std::vector<std::uint8_t> part(9 * 5);
  land.in_world(-4, 57, 9, part);
  int inside = 0;
  for (int n = 0; n < 45; ++n) {
    inside += part[static_cast<std::size_t>(n)];
    EXPECT_EQ(part[static_cast<std::size_t>(n)] != 0, land.in_world(n % 9 - 4, n / 9 + 57));
  }
  EXPECT_GT(inside, 0);
  EXPECT_LT(inside, 45);
}

TEST_F(Slices, AreNoLargerForCoarseTilesThanForLeaves) {
  // Twice as wide a quarter as many: every level has about as many of its own size in a tile.
  json list = json::array();
  for (int i = 0; i < 20'000; ++i) {
    const auto share = [i](int k) { return unit_real(random_bits(5, i, k)); };
    const double radius = 1 / std::sqrt(share(2) + 1e-4);
    list.push_back({800 * share(0), 800 * share(1), 50.0, radius});
  }
  const json text = {
      {"hoodoo", 1},
      {"terrains", {{{"id", "land"}, {"dem", "dem.tif"}}}},
      {"operations",
       {{{"op", "union"}, {"tree", {{"type", "spheres"}, {"falloff", 1}, {"balls", list}}}}}},
      {"bake", {{"tile_cells", 16}}}};
  scene::OpenSettings settings;
  settings.cache = folder_ / "cache";
  const auto scene = scene::open(text, {folder_, {}}, settings);
  const auto plan = plan::make(scene);
  std::vector<std::size_t> bytes(static_cast<std::size_t>(plan.levels));
  std::vector<std::size_t> balls(bytes.size());
  for (const auto& tile : plan.tiles) {
    const auto slice = slice::cut(scene, plan.lattice, tile.key());
    const auto level = static_cast<std::size_t>(tile.level);
    bytes[level] = std::max(bytes[level], slice.bytes().size());
    for (const auto& step : slice.ground.steps) {
      balls[level] = std::max(balls[level], tree::count(step.tree));
    }
  }
  ASSERT_EQ(plan.levels, 5);
  for (std::size_t level = 1; level < bytes.size(); ++level) {
    EXPECT_LE(bytes[level], 4 * bytes[0]) << "level " << level;
    EXPECT_LE(balls[level], 4 * balls[0]) << "level " << level;
  }
}
