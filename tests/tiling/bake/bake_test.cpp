#include "tiling/bake/bake.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/hash.hpp"
#include "engine/scene/sample.hpp"
#include "tiling/tileset/tileset.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A folder with a small DEM, and bakes beside it; removed at the end.
class Bake : public testing::Test {
 protected:
  Bake() {
    static std::atomic<int> serial{0};
    folder_ = fs::temp_directory_path() /
              ("hoodoo-bake-test-" + std::to_string(::getpid()) + "-" + std::to_string(++serial));
    fs::create_directories(folder_);
    scene::SampleDem sample;
    sample.pixels = 100;
    sample.spacing = 8;
    scene::write_sample_dem(folder_ / "dem.tif", sample);
  }
  ~Bake() override { fs::remove_all(folder_); }

  /// 4 x 4 leaves of 32 cells, with a ball half sunk into the ground.
  static json scene(double ball_x = 300) {
    return {{"hoodoo", 1},
            {"name", "bake test"},
            {"terrains", {{{"id", "land"}, {"dem", "dem.tif"}}}},
            {"geology", {{"type", "strata"}, {"wavelength", 30}}},
            {"operations",
             {{{"id", "ball"},
               {"op", "union"},
               {"tree",
                {{"type", "sphere"},
                 {"center", {{"xy", {ball_x, 300}}, {"ground", 0}}},
                 {"radius", 60},
                 {"falloff", 20}}}}}},
            {"bake", {{"tile_cells", 32}}}};
  }

  bake::Report run(const json& scene, const std::string& name, bake::Settings settings = {}) {
    return bake::run(scene, {folder_, {}}, folder_ / name, settings);
  }

  /// Every file below a bake's folder, by relative name, with its digest.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / name)) {
      if (!entry.is_regular_file()) continue;
      found[fs::relative(entry.path(), folder_ / name).string()] =
          sha256(read_file(entry.path(), 1u << 30)).hex();
    }
    return found;
  }

  fs::path folder_;
};

}  // namespace

TEST_F(Bake, GivesTheSameBytesOnOneThreadAndOnThree) {
  bake::Settings three;
  three.threads = 3;
  EXPECT_TRUE(run(scene(), "one").complete);
  EXPECT_TRUE(run(scene(), "three", three).complete);
  EXPECT_GT(files("one").size(), 20U);
  EXPECT_EQ(files("one"), files("three"));
}

TEST_F(Bake, FollowedLiveGivesTheSameBytes) {
  bake::Settings followed;
  followed.live_index = std::chrono::milliseconds(0);
  run(scene(), "followed", followed);
  run(scene(), "alone");
  EXPECT_EQ(files("followed"), files("alone"));
}

TEST_F(Bake, TakesOverWhatIsFinishedAndChangesNoByte) {
  run(scene(), "a");
  const auto before = files("a");
  const auto again = run(scene(), "a");
  EXPECT_EQ(again.progress.reused, again.progress.total);
  EXPECT_EQ(files("a"), before);
}

TEST_F(Bake, TileByTileGivesTheSameBytesAsAllAtOnce) {
  run(scene(), "all");
  const auto bake = json::parse(read_file(folder_ / "all" / "bake.json", 1u << 30));
  ASSERT_GT(bake["tiles"].size(), 16U);
  for (const auto& tile : bake["tiles"]) {
    bake::Settings settings;
    settings.only = plan::Key::parse(tile["key"].get<std::string>());
    ASSERT_TRUE(settings.only);
    run(scene(), "single", settings);
  }
  EXPECT_EQ(files("single"), files("all"));
}

TEST_F(Bake, AnEditBakesOnlyTheTilesInItsReachAgain) {
  run(scene(300), "edited");
  const auto edited = run(scene(310), "edited");
  EXPECT_GT(edited.progress.reused, 4U);
  EXPECT_LT(edited.progress.reused, edited.progress.total);
  run(scene(310), "clean");
  EXPECT_EQ(files("edited"), files("clean"));
}

TEST_F(Bake, IsVerifiedAndIsADiskWithOneBallUnitedToIt) {
  run(scene(), "v");
  const auto found = tileset::verify(folder_ / "v");
  for (const auto& p : found.problems) ADD_FAILURE() << p.where << ": " << p.what;
  ASSERT_TRUE(found.euler.contains(0));
  EXPECT_EQ(found.euler.at(0), 1);
}

TEST_F(Bake, StopsWhenAskedAndContinuesLater) {
  std::stop_source stop;
  bake::Settings settings;
  settings.stop = stop.get_token();
  settings.progress = [&](const bake::Progress& p) {
    if (p.done == 3) stop.request_stop();
  };
  try {
    run(scene(), "stopped", settings);
    FAIL() << "went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::cancelled);
  }
  const auto rest = run(scene(), "stopped");
  EXPECT_GE(rest.progress.reused, 3U);
  run(scene(), "calm");
  EXPECT_EQ(files("stopped"), files("calm"));
}

TEST_F(Bake, RefusesATileThatIsNotInThePlan) {
  bake::Settings settings;
  settings.only = plan::Key{0, 1000, 1000};
  EXPECT_THROW(run(scene(), "none", settings), Error);
}

TEST_F(Bake, BakesADamagedTileAgain) {
  run(scene(), "damaged");
  const auto before = files("damaged");
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "damaged" / "tiles")) {
    if (entry.path().extension() == ".glb") {
      fs::resize_file(entry.path(), 10);
      break;
    }
  }
  const auto again = run(scene(), "damaged");
  EXPECT_LT(again.progress.reused, again.progress.total);
  EXPECT_EQ(files("damaged"), before);
}
