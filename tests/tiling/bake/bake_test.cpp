#include "tiling/bake/bake.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "tests/tiling/bake/folder.hpp"
#include "tiling/tileset/tileset.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;
using Bake = BakeTest;

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

TEST_F(Bake, AnEditLeavesNoFileOfTheSceneBefore) {
  run(scene(300), "edited");
  scene::SampleDem sample{100, 8, 2};  // another seed
  scene::write_sample_dem(folder_ / "dem.tif", sample);
  const auto edited = run(scene(300), "edited");
  EXPECT_EQ(edited.progress.reused, 0U);
  run(scene(300), "clean");
  EXPECT_EQ(files("edited"), files("clean"));
}

TEST_F(Bake, AWrongSceneLeavesNoFolder) {
  auto wrong = scene();
  wrong["bogus"] = 1;
  EXPECT_THROW(run(wrong, "wrong"), Error);
  EXPECT_FALSE(fs::exists(folder_ / "wrong"));
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

TEST_F(Bake, BeginsNoTileWhileACoarserOneWaits) {
  constexpr int threads = 4;
  bake::Settings settings;
  settings.threads = threads;
  std::vector<int> levels;  // of tiles as they end
  settings.progress = [&](const bake::Progress& p) {
    for (const auto& tile : p.finished) levels.push_back(tile.key.level);
  };
  run(scene(), "ordered", settings);
  ASSERT_GT(levels.size(), 8U);
  for (auto end = levels.begin(); end != levels.end(); ++end) {
    EXPECT_LT(std::count_if(end, levels.end(), [&](int later) { return later > *end; }), threads);
  }
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
