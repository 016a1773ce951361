#include "tiling/tileset/tileset.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tests/tiling/tileset/world.hpp"

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

TEST(Record, ComesBackFromItsJson) {
  const Folder folder("record");
  for (const auto& record : World{}.make(folder.path).records) {
    EXPECT_EQ(record_from_json(json::parse(to_json(record).dump()), "here"), record);
  }
  Record empty;
  empty.key = {3, -5, 7};
  empty.empty = true;
  EXPECT_EQ(record_from_json(to_json(empty), "here"), empty);
}

TEST(Record, RefusesWhatIsNoRecordByName) {
  const Folder folder("hostile");
  const json good = to_json(World{}.make(folder.path).records.front());
  const auto refused = [](const json& bad) {
    try {
      record_from_json(bad, "some.json");
      return false;
    } catch (const Error& error) {
      return error.fault == Fault::bad_input && error.problems.front().where == "some.json";
    }
  };
  for (const json& bad : {json(), json(1), json("x"), json::array(), json::object()}) {
    EXPECT_TRUE(refused(bad)) << bad;
  }
  for (const auto& [key, value] : good.items()) {
    for (const json& instead :
         {json(), json(-1), json("zz"), json::array({1, 2}), json::object({{"a", "b"}})}) {
      json bad = good;
      bad[key] = instead;
      if (key == "materials" && instead.is_object()) continue;
      if (key == "simplification" && instead.is_number()) continue;
      EXPECT_TRUE(refused(bad)) << bad;
    }
    json without = good;
    without.erase(key);
    EXPECT_TRUE(refused(without)) << key;
  }
  json upside_down = good;
  std::swap(upside_down["box"][0], upside_down["box"][3]);
  EXPECT_TRUE(refused(upside_down));
}

/// Calls visit(tile, parent or null, folder of its file) over the whole index.
void walk(const fs::path& folder, const fs::path& file, const json* parent,
          const std::function<void(const json&, const json*, const fs::path&)>& visit) {
  const json document = load(folder / file);
  EXPECT_EQ(document.at("asset").at("version"), "1.1");
  const std::function<void(const json&, const json*)> into = [&](const json& tile,
                                                                 const json* above) {
    visit(tile, above, file);
    const auto uri = tile.value("content", json::object()).value("uri", std::string());
    if (uri.ends_with(".json")) {
      walk(folder, (file.parent_path() / uri).lexically_normal(), &tile, visit);
    }
    for (const auto& child : tile.value("children", json::array())) into(child, &tile);
  };
  into(document.at("root"), parent);
}

TEST(Index, HasFilesOfFourLevelsWhoseRootsCarryTheirContent) {
  const Folder folder("index");
  const Bake bake = World{.levels = 6, .strip = true}.make(folder.path);
  const auto files = index(bake, folder.path);
  std::size_t tiles = 0, external = 0;
  walk(folder.path, "tileset.json", nullptr,
       [&](const json& tile, const json* parent, const fs::path& file) {
         const auto uri = tile.at("content").at("uri").get<std::string>();
         const auto target = (file.parent_path() / uri).lexically_normal();
         EXPECT_THAT(files, testing::Contains(target));
         EXPECT_TRUE(fs::exists(folder.path / target)) << target;
         if (uri.ends_with(".json")) {
           ++external;
           EXPECT_FALSE(tile.contains("children"));
           return;
         }
         ++tiles;
         if (parent == nullptr) return;
         if (parent->at("content").at("uri").get<std::string>().ends_with(".json")) {
           EXPECT_EQ(tile.at("boundingVolume"), parent->at("boundingVolume"));
           EXPECT_EQ(tile.at("geometricError"), parent->at("geometricError"));
         } else {
           EXPECT_LT(tile.at("geometricError").get<double>(),
                     parent->at("geometricError").get<double>());
         }
       });
  EXPECT_EQ(tiles, bake.records.size());
  EXPECT_EQ(external, 16U);  // the root of six levels and three below are in tileset.json
}

TEST(Index, IsTheSameBytesForAnyThreadsAndOrder) {
  const Folder folder("same"), other("other");
  Bake bake = World{.levels = 3}.make(folder.path);
  index(bake, folder.path);
  Bake again = World{.levels = 3}.make(other.path);
  std::ranges::reverse(again.records);
  write_index(again, measure_errors(again, other.path, 5), other.path);
  for (const char* file : {"tileset.json", "bake.json"}) {
    EXPECT_EQ(read_file(folder.path / file, 1U << 30), read_file(other.path / file, 1U << 30));
  }
}

TEST(Index, ReadBackWritesTheSameIndex) {
  const Folder folder("whole"), other("read-back");
  Bake bake = World{.levels = 3}.make(folder.path);
  bake.scene = sha256("scene");
  bake.elevations = {sha256("one"), sha256("two")};
  bake.frame = {"EPSG:32632", 1.0 / 3, 500000.125, -7};
  for (const bool complete : {true, false}) {
    if (!complete) std::erase_if(bake.records, [](const Record& r) { return r.key.x == 1; });
    ASSERT_EQ(bake.complete(), complete);
    const auto errors = complete ? measure_errors(bake, folder.path, 2) : estimate_errors(bake);
    write_index(bake, errors, folder.path);
    const Bake read = read_bake(folder.path);
    auto planned = bake.planned;
    std::ranges::sort(planned);
    EXPECT_EQ(read.planned, planned);
    EXPECT_EQ(read.complete(), complete);
    write_index(read, errors, other.path);
    for (const char* file : {"tileset.json", "bake.json"}) {
      EXPECT_EQ(read_file(folder.path / file, 1U << 30), read_file(other.path / file, 1U << 30));
    }
  }
}

TEST(Index, RefusesToReadBackWhatIsDamaged) {
  const Folder folder("damaged-index");
  Bake bake = World{.levels = 2}.make(folder.path);
  bake.records.pop_back();
  write_index(bake, estimate_errors(bake), folder.path);
  const json good = load(folder.path / "bake.json");
  ASSERT_EQ(good.at("missing").size(), 1U);
  const auto refused = [&](const json& bad) {
    write_file(folder.path / "bake.json", bad.dump());
    try {
      read_bake(folder.path);
      return false;
    } catch (const Error& error) {
      return error.fault == Fault::bad_input;
    }
  };
  EXPECT_FALSE(refused(good));
  for (const auto& member : good.items()) {
    for (const json& bad :
         {json(nullptr), json("x"), json::array({-1}), json::object({{"name", 1}})}) {
      json damaged = good;
      damaged[member.key()] = bad;
      if (member.key() == "name" && bad == "x") continue;
      if (member.key() == "engine" && bad == "x") continue;
      if (member.key() == "complete") continue;  // read_manifest's
      EXPECT_TRUE(refused(damaged)) << member.key() << ": " << bad;
    }
  }
}

TEST(Index, ListsWhatIsThereWhenTilesAreMissing) {
  const Folder folder("part");
  Bake bake = World{.levels = 3}.make(folder.path);
  std::erase_if(bake.records, [](const Record& r) { return r.key == plan::Key{0, 1, 1}; });
  index(bake, folder.path);
  EXPECT_EQ(load(folder.path / "bake.json").at("complete"), false);
  EXPECT_EQ(load(folder.path / "bake.json").at("missing"), json::array({"0/1/1"}));
  std::size_t leaves = 0, tiles = 0;
  walk(folder.path, "tileset.json", nullptr, [&](const json& tile, const json*, const fs::path&) {
    ++tiles;
    leaves += tile.contains("children") ? 0 : 1;
  });
  // The parent of the missing tile shows itself instead of three of four children.
  EXPECT_EQ(tiles, 1U + 4U + 12U);
  EXPECT_EQ(leaves, 1U + 12U);
  EXPECT_EQ(texts(verify(folder.path)), "");
}

TEST(Index, ReachesALoneLeafThroughTilesWithoutContent) {
  const Folder folder("lone");
  Bake bake = World{.levels = 3}.make(folder.path);
  std::erase_if(bake.records, [](const Record& r) { return r.key != plan::Key{0, 3, 1}; });
  index(bake, folder.path);
  std::size_t contents = 0;
  walk(folder.path, "tileset.json", nullptr,
       [&](const json& tile, const json* parent, const fs::path&) {
         contents += tile.contains("content") ? 1 : 0;
         if (parent != nullptr) {
           EXPECT_LT(tile.at("geometricError").get<double>(),
                     parent->at("geometricError").get<double>());
         }
       });
  EXPECT_EQ(contents, 1U);
  EXPECT_EQ(texts(verify(folder.path)), "");
}

TEST(Index, ForgetsFilesOfAnEarlierOne) {
  const Folder folder("stale");
  index(World{.levels = 6, .strip = true}.make(folder.path), folder.path);
  const auto count = [&] {
    return std::distance(fs::directory_iterator(folder.path / "subtrees"),
                         fs::directory_iterator());
  };
  EXPECT_EQ(count(), 16);
  const Bake changed = World{.levels = 6, .simplify = 40, .strip = true}.make(folder.path);
  index(changed, folder.path);
  EXPECT_EQ(count(), 16);
}

TEST(Errors, CoverTheDistanceBetweenLevelsAndTakeOverWhatIsKnown) {
  const Folder folder("errors");
  const Bake bake = World{.levels = 3}.make(folder.path);
  const auto errors = measure_errors(bake, folder.path, 1);
  for (const auto& [key, error] : errors) {
    if (key.level == 0) {
      EXPECT_EQ(error, 0);
    } else {
      EXPECT_GT(error, bake.lattice.spacing(key.level) / 16) << "none of these hills is level";
      EXPECT_LT(error, 4 * bake.lattice.spacing(key.level));
      for (const int x : {0, 1}) {
        for (const int y : {0, 1}) {
          EXPECT_GT(error, errors.at({key.level - 1, 2 * key.x + x, 2 * key.y + y}));
        }
      }
    }
  }
  write_index(bake, errors, folder.path);
  fs::remove_all(folder.path / "tiles");  // nothing is read again
  EXPECT_EQ(measure_errors(bake, folder.path, 2), errors);
}

TEST(Errors, SeeAHillThatOnlyTheChildrenHave) {
  const Folder folder("hill");
  World world;
  world.change = [](const plan::Key& key, glb::Content& content) {
    if (key != plan::Key{0, 1, 0}) return;
    for (auto& p : content.surface.points) {
      if (p[0] > 1500 && p[0] < 2500 && p[1] > 1500 && p[1] < 2500) p[2] += 9 * 256;  // 9 m
    }
  };
  const auto errors = measure_errors(world.make(folder.path), folder.path, 1);
  EXPECT_GT(errors.at({1, 0, 0}), 5);
}

TEST(Errors, StopWhenAsked) {
  const Folder folder("stop");
  const Bake bake = World{.levels = 3}.make(folder.path);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(measure_errors(bake, folder.path, 1, stop.get_token()), Error);
}

TEST(Verify, FindsNothingInASoundBake) {
  const Folder folder("sound");
  const Bake bake = World{.levels = 3, .simplify = 60}.make(folder.path);
  index(bake, folder.path);
  const auto found = verify(folder.path);
  EXPECT_EQ(texts(found), "");
  EXPECT_EQ(found.tiles, 21U);
  EXPECT_EQ(found.euler, (std::map<int, std::int64_t>{{0, 1}, {1, 1}, {2, 1}}));
  EXPECT_EQ(found.open_edges, 4U * 17U * 7U);
}

void expect_found(const World& world, const char* what) {
  const Folder folder("spoilt");
  index(world.make(folder.path), folder.path);
  EXPECT_THAT(texts(verify(folder.path)), HasSubstr(what));
}

World spoilt(const std::function<void(glb::Content&)>& change) {
  World world;
  world.change = [change](const plan::Key& key, glb::Content& content) {
    if (key == plan::Key{0, 0, 1}) change(content);
  };
  return world;
}

/// The first vertex on the inner border x = 16 cells, away from corners.
std::size_t border_vertex(const surface::Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.points[i][0] == 4096 && mesh.points[i][1] > 300 && mesh.points[i][1] < 3800) return i;
  }
  return 0;
}

TEST(Verify, FindsABorderVertexThatIsOffByAStep) {
  expect_found(spoilt([](glb::Content& c) { ++c.surface.points[border_vertex(c.surface)][2]; }),
               "level 0: 140 edges have one face, 136 should");
}

TEST(Verify, FindsANormalThatIsNotItsNeighbours) {
  expect_found(spoilt([](glb::Content& c) {
                 c.surface.normals[border_vertex(c.surface)] = {1, 0, 0};
               }),
               "different normals");
}

TEST(Verify, FindsAHole) {
  expect_found(
      spoilt([](glb::Content& c) { c.surface.triangles.erase(c.surface.triangles.begin() + 300); }),
      "3 edges with one face in no plane between cells");
}

TEST(Verify, FindsADoubledTriangle) {
  expect_found(
      spoilt([](glb::Content& c) { c.surface.triangles.push_back(c.surface.triangles[300]); }),
      "doubled");
}

TEST(Verify, FindsATriangleWithoutArea) {
  expect_found(spoilt([](glb::Content& c) {
                 auto& t = c.surface.triangles[300];
                 c.surface.points[t[0]] = c.surface.points[t[1]];
               }),
               "without area");
}

TEST(Verify, FindsDamagedAndMissingFiles) {
  const Folder folder("damaged");
  const Bake bake = World{}.make(folder.path);
  index(bake, folder.path);
  const auto first = folder.path / store::tile_path(bake.records[0].content);
  const auto second = folder.path / store::tile_path(bake.records[1].content);
  fs::remove(first);
  std::ofstream(second, std::ios::app) << "x";
  const auto found = texts(verify(folder.path));
  EXPECT_THAT(found, HasSubstr(first.string()));
  EXPECT_THAT(found, HasSubstr(second.string() + ": its content is not what its name says"));
}

TEST(Verify, FindsATilesetThatIsOff) {
  const Folder folder("off");
  index(World{}.make(folder.path), folder.path);
  json tileset = load(folder.path / "tileset.json");
  tileset["root"]["children"][0]["geometricError"] = 1e9;
  tileset["root"]["children"][1]["boundingVolume"]["box"][3] = 1e9;
  tileset["root"]["children"][2]["content"]["uri"] = "../../elsewhere.glb";
  write_file(folder.path / "tileset.json", tileset.dump());
  const auto found = texts(verify(folder.path));
  EXPECT_THAT(found, HasSubstr("does not fall"));
  EXPECT_THAT(found, HasSubstr("a box leaves its parent's"));
  EXPECT_THAT(found, HasSubstr("names a file outside"));
  EXPECT_THAT(found, HasSubstr("is in bake.json, not in the tileset"));
}

TEST(Verify, RefusesWhatIsNoBake) {
  const Folder folder("none");
  const auto fault = [&] {
    try {
      verify(folder.path);
    } catch (const Error& error) {
      return error.fault;
    }
    return Fault::internal;
  };
  EXPECT_EQ(fault(), Fault::not_found);
  for (const char* text : {"", "[]", "{}", "{\"hoodoo\": 1}", "{\"hoodoo\": 1, \"complete\": 3}",
                           "{\"hoodoo\": 1, \"complete\": true, \"levels\": 70}"}) {
    write_file(folder.path / "bake.json", std::string_view(text));
    EXPECT_EQ(fault(), Fault::bad_input) << text;
  }
  index(World{}.make(folder.path), folder.path);
  for (const char* text : {"", "[]", "{}", "{\"root\": 1}", "{\"geometricError\": 1, \"root\": []}",
                           "{\"geometricError\": 1, \"root\": {\"geometricError\": 0}}"}) {
    write_file(folder.path / "tileset.json", std::string_view(text));
    EXPECT_EQ(fault(), Fault::bad_input) << text;
  }
}

}  // namespace
}  // namespace hoodoo::tileset
