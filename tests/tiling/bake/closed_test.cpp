#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "tests/engine/dem/written_tiff.hpp"
#include "tests/tiling/bake/folder.hpp"
#include "tiling/tileset/tileset.hpp"

using namespace hoodoo;
using nlohmann::json;

namespace {

class ClosedBase : public BakeTest {
 protected:
  static json closed() {
    json all = scene();
    all["bake"]["base"] = {{"closed", 40}};
    return all;
  }
};

}  // namespace

TEST_F(ClosedBase, MakesOneClosedSurfaceAtEveryLevel) {
  ASSERT_TRUE(run(closed(), "closed").complete);
  const auto found = tileset::verify(folder_ / "closed");
  for (const auto& problem : found.problems) ADD_FAILURE() << problem.where << ": " << problem.what;
  EXPECT_EQ(found.open_edges, 0U);
  ASSERT_EQ(found.euler.size(), 3U);
  for (const auto& [level, euler] : found.euler) EXPECT_EQ(euler, 2) << "level " << level;
}

TEST_F(ClosedBase, EndsAtTheFloorAndAtTheWorldsEdge) {
  run(closed(), "closed");
  scene::OpenSettings settings;
  settings.cache = folder_ / "cache";
  const auto scene = scene::open(closed(), {folder_, {}}, settings);
  const auto ground = scene.pyramids[0]->extent();
  ASSERT_TRUE(scene.floor);
  EXPECT_LE(*scene.floor, ground.min.z - 40);
  // Between samples the bicubic may go lower, by (25/16 - 1) / 2 of their range at most.
  EXPECT_GE(*scene.floor, ground.min.z - 40 - 0.282 * (ground.max.z - ground.min.z));
  Box box;
  for (const auto& record : tileset::read_bake(folder_ / "closed").records) {
    if (record.key.level == 0 && !record.empty) box.add(record.box);
  }
  EXPECT_NEAR(box.min.z, *scene.floor, 8.0 / 100);
  EXPECT_NEAR(box.min.x, 0, 8.0 / 100);
  EXPECT_NEAR(box.min.y, 0, 8.0 / 100);
  EXPECT_NEAR(box.max.x, 800, 8.0 / 100);
  EXPECT_NEAR(box.max.y, 800, 8.0 / 100);
}

TEST_F(ClosedBase, HasWallsWhereTheExtentCutsTheTerrain) {
  json cut = closed();
  cut["bake"]["extent"] = {{"min", {37, 100}}, {"max", {500.5, 401}}};
  run(cut, "cut");
  const auto found = tileset::verify(folder_ / "cut");
  EXPECT_TRUE(found.problems.empty());
  EXPECT_EQ(found.open_edges, 0U);
  for (const auto& [level, euler] : found.euler) EXPECT_EQ(euler, 2) << "level " << level;
}

TEST_F(ClosedBase, HasWallsAroundHoles) {
  constexpr int side = 100;
  std::vector<float> samples(side * side);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const bool hole = i >= 40 && i < 55 && j >= 20 && j < 42;
      samples[static_cast<std::size_t>(side * j + i)] =
          hole ? -9999.0F : static_cast<float>(50 + 0.2 * i + (i * j) % 7);
    }
  }
  dem::TiffOptions options;
  options.nodata = "-9999";
  options.scale = {8, 8, 0};
  options.ties = {0, 0, 0, 500'000, 4'000'000, 0};
  options.keys = dem::utm();
  dem::write_tiff(folder_ / "dem.tif", side, side, samples, options);
  json holed = closed();
  holed["operations"] = json::array();
  ASSERT_TRUE(run(holed, "holed").complete);
  const auto found = tileset::verify(folder_ / "holed");
  for (const auto& problem : found.problems) ADD_FAILURE() << problem.where << ": " << problem.what;
  EXPECT_EQ(found.open_edges, 0U);
  for (const auto& [level, euler] : found.euler) EXPECT_EQ(euler, 0) << "level " << level;
}
