#include "tiling/compare/compare.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/tiling/tileset/world.hpp"

namespace hoodoo::compare {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using plan::Key;
using shapes::Folder;
using shapes::World;
using testing::ElementsAre;
using testing::HasSubstr;
using Change = Tile::Change;
using Height = std::function<double(const Key&, double x)>;  // [m]

/// World whose surfaces have this height and look up.
World shaped(const Height& height) {
  World world;
  world.change = [height](const Key& key, glb::Content& content) {
    for (auto& p : content.surface.points) {
      const double x = static_cast<double>(content.origin[0] + p[0]) * content.step;
      p[2] = static_cast<std::int32_t>(height(key, x) / content.step);
    }
    for (auto& n : content.surface.normals) n = {0, 0, 1};
  };
  return world;
}
World flat() {
  return shaped([](const Key&, double) { return 0.0; });
}
World raised(const Key& which, double by) {
  return shaped([=](const Key& key, double) { return key == which ? by : 0.0; });
}

void finish(const tileset::Bake& bake, const fs::path& folder) {
  tileset::write_index(bake, tileset::measure_errors(bake, folder, 2), folder);
}
tileset::Bake bake(const World& world, const fs::path& folder) {
  auto made = world.make(folder);
  finish(made, folder);
  return made;
}

std::vector<std::string> keys(const Comparison& found) {
  std::vector<std::string> names;
  for (const auto& tile : found.tiles) names.push_back(tile.key.text());
  return names;
}

/// Two folders with a bake each.
struct Compare : testing::Test {
  Folder a{"compare-a"}, b{"compare-b"};

  Comparison run(const World& first, const World& second, const Settings& settings = {}) const {
    bake(first, a.path);
    bake(second, b.path);
    return compare(a.path, b.path, settings);
  }
  Error refusal() const {
    try {
      compare(a.path, b.path);
    } catch (const Error& error) {
      return error;
    }
    return {Fault::internal, "", "was not refused"};
  }
};

TEST_F(Compare, ReadsNoTileOfTheSameBake) {
  const auto found = run(World{}, World{});
  EXPECT_TRUE(found.same());
  EXPECT_EQ(found.read, 0U);
  EXPECT_EQ(found.compared, 5U);
  EXPECT_TRUE(found.tiles.empty());
}

TEST_F(Compare, FindsTheTileThatWasRaisedAndByHowMuch) {
  const auto found = run(flat(), raised({0, 1, 0}, 0.5));
  ASSERT_THAT(keys(found), ElementsAre("0/1/0"));
  const auto& tile = found.tiles.front();
  EXPECT_EQ(tile.change, Change::changed);
  EXPECT_DOUBLE_EQ(tile.largest, 0.5);
  // Points nearer than that to the tiles around are nearer to those.
  EXPECT_LT(tile.mean, 0.5);
  EXPECT_GT(tile.mean, 0.45);
  EXPECT_NEAR(tile.normal, 0, 1e-9);
  EXPECT_LT(tile.material, 0.01) << "there, the material beside may be another one";
  EXPECT_FALSE(found.same());
}

TEST_F(Compare, IsTheSameWithinTheTolerance) {
  EXPECT_TRUE(run(flat(), raised({0, 1, 0}, 0.5), {.tolerance = 0.5}).same());
  EXPECT_FALSE(compare(a.path, b.path, {.tolerance = 0.49}).same());
}

TEST_F(Compare, AllowsALevelAsMuchMoreAsItsSpacingIsLarger) {
  EXPECT_TRUE(run(flat(), raised({1, 0, 0}, 0.5), {.tolerance = 0.25}).same());
  EXPECT_FALSE(compare(a.path, b.path, {.tolerance = 0.24}).same());
}

TEST_F(Compare, FindsTheNearestPointInTheTileBeside) {
  // A cliff of 4 m moves over the border at 16 m. Within the eastern tile alone, the new high
  // ground is 4 m from anything.
  const auto cliff = [](double at) {
    return shaped([=](const Key& key, double x) { return key.level == 0 && x < at ? 4.0 : 0.0; });
  };
  const auto found = run(cliff(15.5), cliff(17));
  ASSERT_EQ(found.count(Change::changed), found.tiles.size());
  EXPECT_THAT(keys(found), testing::UnorderedElementsAre("0/0/0", "0/0/1", "0/1/0", "0/1/1"));
  EXPECT_GT(found.largest(0), 1);
  EXPECT_LT(found.largest(0), 3);
}

TEST_F(Compare, MeasuresTurnedNormals) {
  World turned = flat();
  turned.change = [flatten = turned.change](const Key& key, glb::Content& content) {
    flatten(key, content);
    if (key == Key{0, 0, 1})
      content.surface.normals.assign(content.surface.normals.size(), {0.5F, 0, 0.8660254F});
  };
  const auto found = run(flat(), turned);
  ASSERT_THAT(keys(found), ElementsAre("0/0/1"));
  EXPECT_NEAR(found.tiles.front().normal, 30, 0.3) << "10 octahedral bits";
  EXPECT_EQ(found.tiles.front().largest, 0);
}

/// Chalk in the west, up to `border` [m].
World layered(int border) {
  World world = flat();
  world.levels = 1;
  world.change = [=, flatten = world.change](const Key& key, glb::Content& content) {
    flatten(key, content);
    for (std::size_t i = 0; i < content.surface.points.size(); ++i) {
      content.surface.materials[i] = content.surface.points[i][0] < border * 256 ? 1 : 0;
    }
  };
  return world;
}

TEST_F(Compare, MeasuresTheShareOfAnotherMaterial) {
  const auto found = run(layered(0), layered(4));
  ASSERT_THAT(keys(found), ElementsAre("0/0/0"));
  EXPECT_NEAR(found.tiles.front().material, 4.0 / 16, 0.05) << "triangles lie between";
  EXPECT_EQ(found.tiles.front().largest, 0);
  EXPECT_FALSE(compare(a.path, b.path, {.tolerance = 100}).same()) << "there was no chalk";
}

TEST_F(Compare, LetsMaterialsMoveWithinTheTolerance) {
  EXPECT_FALSE(run(layered(4), layered(8), {.tolerance = 1}).same());
  EXPECT_TRUE(compare(a.path, b.path, {.tolerance = 6}).same());
}

TEST_F(Compare, NamesTilesThatAreAddedOrGone) {
  World strip;
  strip.strip = true;
  const auto found = run(strip, World{}, {.tolerance = 1e6});
  EXPECT_EQ(found.count(Change::added), 2U);
  EXPECT_THAT(keys(found), testing::IsSupersetOf({"0/0/1", "0/1/1"}));
  EXPECT_EQ(found.tiles.front().change, Change::added) << "the worst first";
  EXPECT_FALSE(found.same());
  EXPECT_EQ(compare(b.path, a.path, {.tolerance = 1e6}).count(Change::gone), 2U);
}

TEST_F(Compare, PutsTheWorstFirst) {
  const auto found = run(flat(), shaped([](const Key& key, double) {
                           return key == Key{0, 0, 0} ? 0.25 : key == Key{0, 1, 1} ? 2 : 0;
                         }));
  EXPECT_THAT(keys(found), ElementsAre("0/1/1", "0/0/0"));
}

TEST_F(Compare, ComparesTheCommonGroundWhereOriginsDiffer) {
  bake(flat(), a.path);
  auto moved = raised({0, 0, 1}, 0.5).make(b.path);
  moved.frame.origin_x = 16;  // the tiles of column 0 lie over those of column 1
  finish(moved, b.path);
  const auto found = compare(a.path, b.path);
  EXPECT_TRUE(found.by_region);
  EXPECT_EQ(found.compared, 2U);
  ASSERT_THAT(keys(found), testing::Contains("0/1/1"));
  EXPECT_EQ(found.tiles.front().key.text(), "0/1/1");
  EXPECT_NEAR(found.tiles.front().largest, 0.5, 1e-12);
  EXPECT_TRUE(compare(a.path, b.path, {.tolerance = 0.51}).same());
}

TEST_F(Compare, RefusesBakesWithoutCommonGroundOrFrame) {
  bake(flat(), a.path);
  auto other = flat().make(b.path);
  other.frame.origin_x = 1000;
  finish(other, b.path);
  EXPECT_THAT(refusal().what(), HasSubstr("no ground in common"));
  other.frame.crs = "EPSG:32632";
  finish(other, b.path);
  EXPECT_THAT(refusal().what(), HasSubstr("in another frame: EPSG:32632, not a local frame"));
  EXPECT_EQ(refusal().fault, Fault::bad_input);
}

TEST_F(Compare, RefusesWhatIsNoFinishedBake) {
  bake(flat(), a.path);
  EXPECT_THAT(refusal().what(), HasSubstr(b.path.string() + ": holds no bake"));
  auto part = flat().make(b.path);
  part.records.pop_back();
  finish(part, b.path);
  EXPECT_THAT(refusal().what(), HasSubstr(b.path.string() + ": holds a bake that is not finished"));
  fs::remove_all(b.path);
  EXPECT_EQ(refusal().fault, Fault::not_found);
}

TEST_F(Compare, RefusesTilesThatAreMissingEvenWhereTheyAreEqual) {
  bake(flat(), a.path);
  const auto records = bake(flat(), b.path).records;
  const auto file = b.path / store::tile_path(records.front().content);
  fs::remove(file);
  EXPECT_THAT(refusal().what(), HasSubstr(file.string() + ": tile "));
  EXPECT_EQ(refusal().fault, Fault::bad_input);
}

TEST_F(Compare, RefusesATileThatItReadsAndFindsDamaged) {
  bake(flat(), a.path);
  const auto records = bake(raised({0, 0, 0}, 1), b.path).records;
  const auto file = b.path / store::tile_path(records.front().content);
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('~');
  EXPECT_THAT(refusal().what(),
              HasSubstr(file.string() + ": its content is not what its name says"));
}

TEST_F(Compare, ReadsATileAFewTimesAtMost) {
  World low = flat(), high = shaped([](const Key&, double) { return 1.0; });
  low.levels = high.levels = 4;
  const auto found = run(low, high);
  EXPECT_EQ(found.tiles.size(), found.compared);
  EXPECT_LE(found.read, 4 * 2 * found.compared);
}

TEST_F(Compare, DrawsTheWorstTilesIntoAPageThatNamesNothingOutside) {
  const auto found = run(flat(), raised({0, 1, 0}, 0.5), {.pictures = 3});
  ASSERT_EQ(found.views.size(), 1U);
  const auto& [key, first, second] = found.views.front();
  EXPECT_EQ(key, (Key{0, 1, 0}));
  EXPECT_NE(first.rgb, second.rgb);
  EXPECT_NE(std::ranges::count(first.rgb, first.rgb.front()), std::ssize(first.rgb));
  const auto text = page(found, "<a>", "b");
  EXPECT_THAT(text, HasSubstr("<p>&lt;a> and b</p>"));
  EXPECT_THAT(text, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(text, testing::Not(testing::AnyOf(HasSubstr("http"), HasSubstr("<script"),
                                                HasSubstr("url("))));
}

TEST_F(Compare, IsJsonWithTheDocumentedKeys) {
  const json found = to_json(run(flat(), raised({0, 1, 0}, 0.5)));
  for (const char* key :
       {"same", "tolerance", "by", "spacings", "compared", "equal", "changed", "added", "gone",
        "beyond", "read", "largest", "mean", "levels", "tiles"}) {
    EXPECT_TRUE(found.contains(key)) << key;
  }
  EXPECT_EQ(found["equal"], 4);
  EXPECT_EQ(found["tiles"][0]["key"], "0/1/0");
  EXPECT_EQ(found["tiles"][0]["change"], "changed");
  EXPECT_EQ(found["levels"][0]["largest"], 0.5);
}

}  // namespace
}  // namespace hoodoo::compare
