#include "tiling/slice/slice.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/scene/sample.hpp"
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
}
