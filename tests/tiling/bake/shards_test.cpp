// Parts of one bake, at once or one after the other, and what joins them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/tiling/bake/folder.hpp"
#include "tiling/bake/merge.hpp"
#include "tiling/tileset/tileset.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

namespace {

class Shards : public BakeTest {
 protected:
  bake::Report shard(const std::string& name, std::int64_t index, std::int64_t count,
                     const json& what = scene()) {
    bake::Settings settings;
    settings.shard = plan::Shard{index, count};
    return run(what, name, settings);
  }
  bake::MergeReport merge(const std::vector<std::string>& parts, const std::string& into) {
    std::vector<fs::path> folders;
    for (const auto& part : parts) folders.push_back(folder_ / part);
    return bake::merge(folders, folder_ / into, {2, {}});
  }
  std::string refusal(const std::vector<std::string>& parts, const std::string& into) {
    try {
      merge(parts, into);
    } catch (const Error& error) {
      EXPECT_EQ(error.fault, Fault::bad_input);
      return error.what() + error.problems.at(0).what;
    }
    return "none";
  }
};

}  // namespace

TEST_F(Shards, AtOnceInOneFolderGiveTheBytesOfOneBake) {
  run(scene(), "one");
  const auto expected = files("one");
  for (const int count : {3, 8}) {
    const auto name = "shards-" + std::to_string(count);
    {
      std::vector<std::jthread> runs;
      for (int i = 1; i <= count; ++i) runs.emplace_back([=, this] { shard(name, i, count); });
    }
    EXPECT_EQ(files(name), expected) << count;
  }
}

TEST_F(Shards, OneAfterTheOtherEachLeaveAnIndexOfWhatIsThere) {
  run(scene(), "one");
  std::uint64_t before = 0;
  for (int i = 1; i <= 3; ++i) {
    const auto report = shard("parts", i, 3);
    const auto bake = tileset::read_bake(folder_ / "parts");
    EXPECT_EQ(report.complete, i == 3);
    EXPECT_EQ(bake.complete(), i == 3);
    EXPECT_EQ(report.progress.done, bake.records.size());
    EXPECT_EQ(report.progress.total, bake.planned.size());
    EXPECT_EQ(report.progress.reused, before);
    EXPECT_GT(bake.records.size(), before);
    before = bake.records.size();
  }
  EXPECT_EQ(files("parts"), files("one"));
}

TEST_F(Shards, ABakeGoesOnWhereAShardEnded) {
  run(scene(), "one");
  const auto part = shard("part", 2, 3);
  const auto rest = run(scene(), "part");
  EXPECT_EQ(rest.progress.reused, part.progress.done);
  EXPECT_EQ(files("part"), files("one"));
}

TEST_F(Shards, MoreThanThereAreTilesAreNoMistake) {
  const auto report = shard("many", 1, 1000);
  EXPECT_EQ(report.progress.done, 0U);
  EXPECT_FALSE(report.complete);
}

TEST_F(Shards, OfAnEditLeaveNoFileOfTheSceneBefore) {
  run(scene(310), "clean");
  run(scene(300), "edited");
  {
    std::vector<std::jthread> runs;
    for (int i = 1; i <= 3; ++i)
      runs.emplace_back([=, this] { shard("edited", i, 3, scene(310)); });
  }
  EXPECT_EQ(files("edited"), files("clean"));
}

TEST_F(Shards, MergedGiveTheBytesOfOneBake) {
  run(scene(), "one");
  for (int i = 1; i <= 3; ++i) shard("part-" + std::to_string(i), i, 3);
  const auto first = merge({"part-3", "part-1"}, "merged");
  EXPECT_EQ(first.copied, first.tiles);
  const auto missing = tileset::read_bake(folder_ / "part-2").records;
  ASSERT_EQ(first.missing.size(), missing.size());
  for (std::size_t i = 0; i < missing.size(); ++i) EXPECT_EQ(first.missing[i], missing[i].key);
  EXPECT_FALSE(tileset::read_bake(folder_ / "merged").complete());

  const auto second = merge({"part-2"}, "merged");
  EXPECT_EQ(second.copied, missing.size());
  EXPECT_TRUE(second.missing.empty());
  EXPECT_EQ(files("merged"), files("one"));

  const auto again = merge({"part-1", "part-2", "part-3"}, "merged");
  EXPECT_EQ(again.copied, 0U);
  EXPECT_EQ(files("merged"), files("one"));
}

TEST_F(Shards, AMergeThatLacksTilesIsContinuedByABake) {
  run(scene(), "one");
  shard("part", 1, 2);
  const auto merged = merge({"part"}, "merged");
  const auto rest = run(scene(), "merged");
  EXPECT_EQ(rest.progress.reused, merged.tiles);
  EXPECT_EQ(files("merged"), files("one"));
}

TEST_F(Shards, OfDifferentScenesAreNotMerged) {
  shard("a", 1, 2);
  shard("b", 2, 2, scene(310));
  EXPECT_THAT(refusal({"a", "b"}, "merged"), HasSubstr("operations, geology or bake settings"));
  auto named = scene();
  named["name"] = "another";
  shard("named", 2, 2, named);
  EXPECT_THAT(refusal({"a", "named"}, "merged"),
              HasSubstr("its scene's name is another, not bake test"));
  auto coarse = scene();
  coarse["bake"]["spacing"] = 16;
  shard("coarse", 2, 2, coarse);
  EXPECT_THAT(refusal({"a", "coarse"}, "merged"), HasSubstr("its spacing is 16 m, not 8 m"));
  scene::write_sample_dem(folder_ / "dem.tif", {100, 8, 2});
  shard("elsewhere", 2, 2);
  EXPECT_THAT(refusal({"a", "elsewhere"}, "merged"), HasSubstr("its elevations"));
  EXPECT_FALSE(fs::exists(folder_ / "merged")) << "nothing is written";
  EXPECT_THAT(refusal({"a"}, "b"), HasSubstr("another scene")) << "nor over another bake";
}

TEST_F(Shards, DamagedAreNotMergedUnlessAnotherHasTheTile) {
  run(scene(), "one");
  shard("a", 1, 2);
  shard("b", 2, 2);
  const auto whole = tileset::read_bake(folder_ / "a").records;
  const auto record = std::ranges::find(whole, false, &tileset::Record::empty);
  ASSERT_NE(record, whole.end());
  const auto hex = record->content.hex();
  const auto tile = fs::path("tiles") / hex.substr(0, 2) / (hex + ".glb");
  auto bytes = read_file(folder_ / "a" / tile, 1U << 30);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_file(folder_ / "a" / tile, bytes);
  EXPECT_THAT(refusal({"a", "b"}, "merged"), HasSubstr("not what its name says"));
  EXPECT_FALSE(fs::exists(folder_ / "merged" / "tileset.json"));
  merge({"a", "b", "one"}, "merged");
  EXPECT_EQ(files("merged"), files("one"));
}
