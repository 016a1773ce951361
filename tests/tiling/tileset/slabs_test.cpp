#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "engine/base/lock.hpp"
#include "tests/tiling/tileset/world.hpp"

/// Tiles of several files, and files that are of no tile.
namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using shapes::Folder;
using shapes::World;
using testing::HasSubstr;

std::string texts(const Verification& verification) {
  std::string all;
  for (const auto& problem : verification.problems)
    all += problem.where + ": " + problem.what + "\n";
  return all;
}

std::vector<fs::path> index(const Bake& bake, const fs::path& folder) {
  return write_index(bake, measure_errors(bake, folder, 2), folder);
}

TEST(SlabRecord, ComesBackFromItsJson) {
  const Folder folder("slab-record");
  for (const auto& record : World{.slab = 100}.make(folder.path).records) {
    EXPECT_GT(record.slabs.size(), 2U);
    EXPECT_EQ(record_from_json(json::parse(to_json(record).dump()), "here"), record);
    EXPECT_EQ(record.files(), record.slabs);
  }
}

TEST(SlabRecord, SumsUpItsFiles) {
  const Folder folder("slab-sums"), other("slab-sums-whole");
  const auto slabs = World{.slab = 100}.make(folder.path).records;
  const auto whole = World{}.make(other.path).records;
  ASSERT_EQ(slabs.size(), whole.size());
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    EXPECT_EQ(slabs[i].triangles, whole[i].triangles);
    EXPECT_EQ(slabs[i].skirt_triangles, whole[i].skirt_triangles);
    EXPECT_EQ(slabs[i].box, whole[i].box);
    ASSERT_EQ(whole[i].files().size(), 1U);
    EXPECT_EQ(whole[i].files()[0].content, whole[i].content);
  }
}

TEST(SlabRecord, RefusesASingleSlab) {
  const Folder folder("slab-single");
  auto text = to_json(World{.slab = 100}.make(folder.path).records[0]);
  text["contents"].erase(text["contents"].begin() + 1, text["contents"].end());
  EXPECT_THROW(record_from_json(text, "here"), Error);
  text["contents"] = 3;
  EXPECT_THROW(record_from_json(text, "here"), Error);
}

TEST(SlabIndex, NamesEveryFileOfATileWithItsOwnBox) {
  const Folder folder("slab-index");
  const Bake bake = World{.slab = 100}.make(folder.path);
  const auto files = index(bake, folder.path);
  const json root = load(folder.path / "tileset.json")["root"];
  const auto& record = bake.records.back();
  EXPECT_FALSE(root.contains("content"));
  ASSERT_EQ(root["contents"].size(), record.slabs.size());
  for (std::size_t i = 0; i < record.slabs.size(); ++i) {
    const auto path = store::tile_path(record.slabs[i].content);
    EXPECT_EQ(root["contents"][i]["uri"], path.generic_string());
    EXPECT_TRUE(std::ranges::binary_search(files, path));
    const Box& box = record.slabs[i].box;
    const json numbers = root["contents"][i]["boundingVolume"]["box"];
    EXPECT_EQ(numbers[2], (box.min.z + box.max.z) / 2);
  }
  EXPECT_EQ(read_bake(folder.path).records, [&] {
    auto sorted = bake.records;
    std::ranges::sort(sorted, {}, &Record::key);
    return sorted;
  }());
}

TEST(SlabErrors, AreThoseOfTheWholeTiles) {
  const Folder folder("slab-errors"), other("slab-errors-whole");
  // Slabs change the order of triangles, so the search's slack may be spent otherwise.
  const auto slabs = measure_errors(World{.slab = 100}.make(folder.path), folder.path, 1);
  const auto whole = measure_errors(World{}.make(other.path), other.path, 1);
  for (const auto& [key, error] : whole) EXPECT_NEAR(slabs.at(key), error, 1.0 / 8);
}

TEST(SlabVerify, FindsNothingInASoundBake) {
  const Folder folder("slab-sound"), other("slab-sound-whole");
  index(World{.levels = 3, .slab = 100}.make(folder.path), folder.path);
  index(World{.levels = 3}.make(other.path), other.path);
  const auto slabs = verify(folder.path), whole = verify(other.path);
  EXPECT_EQ(texts(slabs), "");
  EXPECT_EQ(slabs.euler, whole.euler);
  EXPECT_EQ(slabs.border_vertices, whole.border_vertices);
  EXPECT_EQ(slabs.open_edges, whole.open_edges);
  EXPECT_EQ(slabs.tiles, whole.tiles);
}

TEST(SlabVerify, FindsASlabThatIsMissing) {
  const Folder folder("slab-missing");
  const Bake bake = World{.slab = 100}.make(folder.path);
  index(bake, folder.path);
  const auto file = folder.path / store::tile_path(bake.records[0].slabs[1].content);
  fs::remove(file);
  EXPECT_THAT(texts(verify(folder.path)), HasSubstr(file.string()));
}

TEST(SlabVerify, FindsAContentWhoseBoxIsOff) {
  const Folder folder("slab-box");
  index(World{.slab = 100}.make(folder.path), folder.path);
  json tileset = load(folder.path / "tileset.json");
  tileset["root"]["contents"][0]["boundingVolume"]["box"][11] = 1e-3;
  tileset["root"]["contents"][1]["boundingVolume"]["box"][11] = 1e6;
  write_file(folder.path / "tileset.json", tileset.dump());
  const auto found = texts(verify(folder.path));
  EXPECT_THAT(found, HasSubstr("its box in the tileset is too small"));
  EXPECT_THAT(found, HasSubstr("a content's box leaves its tile's"));
}

TEST(Orphans, AreCountedAndNamed) {
  const Folder folder("orphans");
  index(World{}.make(folder.path), folder.path);
  for (const char* name : {"notes.txt", "tiles/zz/old.glb", "subtrees/9-0-0.json", "tiles/a.tmp"}) {
    write_file(folder.path / name, std::string_view("x"));
  }
  write_file(folder.path / ".hoodoo" / "anything", std::string_view("x"));
  const auto found = texts(verify(folder.path));
  EXPECT_THAT(found, HasSubstr("4 files that no index names: notes.txt, subtrees/9-0-0.json, "
                               "tiles/a.tmp, tiles/zz/old.glb"));
}

TEST(Orphans, AreNamedUpToFive) {
  const Folder folder("many-orphans");
  index(World{}.make(folder.path), folder.path);
  for (char c = 'a'; c <= 'h'; ++c) {
    write_file(folder.path / "tiles" / (std::string(1, c) + ".glb"), std::string_view("x"));
  }
  const auto found = texts(verify(folder.path));
  EXPECT_THAT(found, HasSubstr("8 files that no index names: tiles/a.glb, tiles/b.glb, "
                               "tiles/c.glb, tiles/d.glb, tiles/e.glb, ..."));
}

TEST(Orphans, AreNoneOfARunAtWork) {
  const Folder folder("orphans-at-work");
  index(World{}.make(folder.path), folder.path);
  write_file(folder.path / "tiles/zz/next.glb", std::string_view("x"));
  {
    const FileLock use(folder.path / ".hoodoo" / "use.lock", FileLock::Kind::shared, {});
    EXPECT_EQ(texts(verify(folder.path)), "");
    write_file(folder.path / "notes.txt", std::string_view("x"));
    EXPECT_THAT(texts(verify(folder.path)), HasSubstr("1 files that no index names: notes.txt"));
  }
  EXPECT_THAT(texts(verify(folder.path)), HasSubstr("2 files that no index names"));
}

}  // namespace
}  // namespace hoodoo::tileset
