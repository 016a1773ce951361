// What levels keep, and tiles of several files.
#include <gtest/gtest.h>

#include "engine/base/json.hpp"
#include "tests/tiling/bake/folder.hpp"
#include "tiling/bake/merge.hpp"
#include "tiling/tileset/tileset.hpp"

using namespace hoodoo;
using nlohmann::json;

/// What a level keeps, and in how many files.
class Levels : public BakeTest {
 protected:
  /// Level ground, 128 x 128 m in 1 m, over which an arch 3 m thick spans 40 m.
  json arch(bool keep_thin) const {
    scene::SampleDem sample;
    sample.pixels = 128;
    sample.spacing = 1;
    scene::write_sample_dem(folder_ / "fine.tif", sample);
    return {{"hoodoo", 1},
            {"name", "arch"},
            {"terrains", {{{"id", "land"}, {"dem", "fine.tif"}}}},
            {"operations",
             {{{"id", "arch"},
               {"op", "union"},
               {"tree",
                {{"type", "torus"},
                 {"center", {{"xy", {64, 64}}, {"ground", 0}}},
                 {"axis", {0, 1, 0}},
                 {"radius", 20},
                 {"tube", 1.5},
                 {"falloff", 1.5}}}}}},
            {"bake", {{"tile_cells", 32}, {"spacing", 1}, {"keep_thin", keep_thin}}}};
  }
  json manifest(const std::string& name) const {
    const auto file = folder_ / name / "bake.json";
    return parse_json(read_file(file, 1 << 24), file.string());
  }
  std::string verified(const std::string& name) const {
    std::string all;
    for (const auto& problem : tileset::verify(folder_ / name).problems) {
      all += problem.where + ": " + problem.what + "\n";
    }
    return all;
  }
};

TEST_F(Levels, OfFourMetresLoseAnArchOfThree) {
  run(arch(false), "bake");
  EXPECT_EQ(verified("bake"), "");
  const auto found = tileset::verify(folder_ / "bake");
  EXPECT_NE(found.euler.at(2), found.euler.at(0));
  EXPECT_FALSE(manifest("bake")["lattice"].contains("finer"));
}

TEST_F(Levels, OfFourMetresKeepAnArchOfThreeWhereAsked) {
  run(arch(true), "bake");
  EXPECT_EQ(verified("bake"), "");
  EXPECT_EQ(manifest("bake")["lattice"]["finer"], json({0, 1, 2}));
  const auto found = tileset::verify(folder_ / "bake");
  EXPECT_EQ(found.euler.at(2), found.euler.at(0)) << "its opening and its hold are the leaves'";
}

TEST_F(Levels, ThatKeepWhatIsThinAreTheSameOnAnyThreadsAndInParts) {
  bake::Settings two;
  two.threads = 2;
  run(arch(true), "one");
  run(arch(true), "two", two);
  EXPECT_EQ(files("one"), files("two"));
}

TEST_F(Levels, WithoutAnythingThinAreAsEver) {
  auto kept = scene();
  kept["bake"]["keep_thin"] = true;
  run(scene(), "plain");
  run(kept, "kept");
  const auto plain = manifest("plain"), with = manifest("kept");
  EXPECT_EQ(plain["tiles"], with["tiles"]);
}

class SlabBake : public Levels {
 protected:
  static json in_slabs() {
    auto scene = BakeTest::scene();
    scene["bake"]["tile_triangles"] = 1000;
    scene["bake"]["simplify"] = 0;
    return scene;
  }
};

TEST_F(SlabBake, HasTheSurfaceOfTheWholeTilesAndPassesVerification) {
  auto whole = in_slabs();
  whole["bake"].erase("tile_triangles");
  run(whole, "whole");
  run(in_slabs(), "slabs");
  EXPECT_EQ(verified("slabs"), "");
  const auto a = tileset::verify(folder_ / "whole"), b = tileset::verify(folder_ / "slabs");
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.euler, b.euler);
  EXPECT_EQ(a.border_vertices, b.border_vertices);
  std::size_t split = 0;
  const auto bake = manifest("slabs");
  for (const auto& tile : bake["tiles"]) split += tile.contains("contents") ? 1 : 0;
  EXPECT_GT(split, 5U);
}

TEST_F(SlabBake, IsMergedFromShards) {
  run(in_slabs(), "whole");
  bake::Settings part;
  part.shard = plan::Shard{1, 2};
  run(in_slabs(), "a", part);
  part.shard = plan::Shard{2, 2};
  run(in_slabs(), "b", part);
  bake::merge({folder_ / "a", folder_ / "b"}, folder_ / "merged", {});
  EXPECT_EQ(files("merged"), files("whole"));
}

TEST_F(SlabBake, IsTakenUpAgainFileByFile) {
  run(in_slabs(), "bake");
  const auto before = files("bake");
  const auto again = run(in_slabs(), "bake");
  EXPECT_EQ(again.progress.reused, again.progress.done);
  EXPECT_EQ(files("bake"), before);
  // One lost slab costs its tile, and nothing else.
  std::filesystem::path lost;
  const auto bake = manifest("bake");
  for (const auto& tile : bake["tiles"]) {
    if (tile.contains("contents")) lost = tile["contents"][1]["uri"].get<std::string>();
  }
  std::filesystem::remove(folder_ / "bake" / lost);
  const auto mended = run(in_slabs(), "bake");
  EXPECT_EQ(mended.progress.reused, mended.progress.done - 1);
  EXPECT_EQ(files("bake"), before);
}

TEST_F(SlabBake, ComesWholeOutOfACache) {
  bake::Settings cached;
  cached.cache = folder_ / "cache";
  run(in_slabs(), "first", cached);
  const auto second = run(in_slabs(), "second", cached);
  EXPECT_EQ(second.progress.cached, second.progress.done);
  EXPECT_EQ(files("first"), files("second"));
}
