#include "tiling/plan/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

using namespace hoodoo;
using plan::Key;

TEST(Key, ReadsWhatItWrites) {
  const Key key{3, 17, 0};
  EXPECT_EQ(key.text(), "3/17/0");
  EXPECT_EQ(Key::parse("3/17/0"), key);
}

TEST(Key, RefusesWhatIsNoKey) {
  for (const auto* text :
       {"", "3", "3/1", "3/1/2/4", "3/1/2 ", "a/1/2", "-1/0/0", "3//2", "3/1/"}) {
    EXPECT_EQ(Key::parse(text), std::nullopt) << text;
  }
}

TEST(Key, HasTheParentThatCoversItAtTwiceTheSpacing) {
  EXPECT_EQ((Key{0, 5, 8}.parent()), (Key{1, 2, 4}));
  EXPECT_EQ((Key{4, 0, 1}.parent()), (Key{5, 0, 0}));
}

TEST(Lattice, CountsBetween256And511StepsPerCell) {
  for (double spacing = 0.01; spacing < 5000; spacing *= 1.07) {
    const double rounded = dem::rounded_spacing(spacing);
    const plan::Lattice lattice{rounded, dem::step_of(rounded), 128};
    EXPECT_GE(lattice.units(), 256) << spacing;
    EXPECT_LE(lattice.units(), 512) << spacing;
    EXPECT_EQ(lattice.units() * lattice.step0, rounded) << "a whole number of steps";
    EXPECT_NEAR(rounded, spacing, spacing / 512);
  }
}

TEST(Lattice, GivesAParentTheAreaOfItsFourChildren) {
  const plan::Lattice lattice{2.5, dem::step_of(2.5), 128};
  const Box parent = lattice.area({1, 3, 4});
  EXPECT_EQ(parent.min.x, lattice.area({0, 6, 8}).min.x);
  EXPECT_EQ(parent.max.x, lattice.area({0, 7, 8}).max.x);
  EXPECT_EQ(parent.max.y, lattice.area({0, 7, 9}).max.y);
}

TEST(Lattice, GivesALevelSampledFinerTheStepsAndTheAreaOfItsTiles) {
  plan::Lattice lattice{2, 1.0 / 128, 128, {0, 1, 2}};
  EXPECT_EQ(lattice.step(0), lattice.step(1));
  EXPECT_EQ(lattice.step(0), lattice.step(2));
  EXPECT_EQ(lattice.step(3), 8 * lattice.step(0)) << "beyond the list, as ever";
  EXPECT_EQ(static_cast<double>(lattice.side(2)) * lattice.step(2), 128 * lattice.spacing(2));
  const auto [sampled, key] = plan::sampling_of(lattice, {2, 3, -4});
  EXPECT_EQ(key, (Key{0, 3, -4}));
  EXPECT_EQ(sampled.tile_cells, 512);
  EXPECT_EQ(sampled.area(key).min.x, lattice.area({2, 3, -4}).min.x);
  EXPECT_EQ(sampled.area(key).max.y, lattice.area({2, 3, -4}).max.y);
  EXPECT_EQ(sampled.step(key.level), lattice.step(2));
}

namespace {

/// Spheres so thick [m], one beside the other, to be kept.
scene::Scene spheres(std::vector<double> thicknesses) {
  scene::Scene scene;
  scene.bake.keep_thin = true;
  scene.extent = Box{{0, 0, 0}, {1000, 1000, 100}};
  for (const double thickness : thicknesses) {
    tree::Sphere sphere;
    sphere.center.value = {100.0 * static_cast<double>(scene.ground.steps.size()) + 50, 500, 50};
    sphere.radius = thickness / 2;
    sphere.falloff = thickness / 2;
    scene.ground.steps.push_back({"", "", tree::Operation::unite, {sphere, {}}, nullptr, -1});
  }
  return scene;
}

std::vector<int> finer(const scene::Scene& scene, int tile_cells = 128) {
  return plan::finer_levels(scene, {1, 1.0 / 256, tile_cells, {}}, 7);
}

}  // namespace

TEST(FinerLevels, AreThoseWithAFeatureThinnerThanTwoCells) {
  // 3 m are less than two cells of 2 m, than one of 4 m and more, but of 32 m / 4 less than half a
  // cell.
  EXPECT_EQ(finer(spheres({3})), (std::vector<int>{0, 1, 2, 2, 2, 0, 0}));
  EXPECT_EQ(finer(spheres({3, 24})), (std::vector<int>{0, 1, 2, 2, 2, 2, 2}));
  EXPECT_EQ(finer(spheres({600})), (std::vector<int>{}));
  EXPECT_EQ(finer(spheres({0.4})), (std::vector<int>{})) << "not to be seen at level 0 either";
}

TEST(FinerLevels, AreNoneWhereNotAskedFor) {
  auto scene = spheres({3});
  scene.bake.keep_thin = false;
  EXPECT_EQ(finer(scene), (std::vector<int>{}));
}

TEST(FinerLevels, KeepTilesToFiveHundredAndTwelveCells) {
  EXPECT_EQ(finer(spheres({3}), 256), (std::vector<int>{0, 1, 1, 1, 0, 0, 0}));
  EXPECT_EQ(finer(spheres({3}), 512), (std::vector<int>{}));
}

TEST(Plan, FindsATileByItsKey) {
  std::vector<plan::Tile> tiles;
  for (const Key& key : {Key{0, -2, 5}, Key{0, 1, 0}, Key{1, -1, 2}}) tiles.emplace_back(key);
  EXPECT_EQ(plan::find(std::span(tiles), {0, 1, 0}), &tiles[1]);
  EXPECT_EQ(plan::find(std::span(tiles), {0, 1, 1}), nullptr);
  EXPECT_EQ(plan::find(std::span(tiles), {2, 0, 0}), nullptr);
}

TEST(Shard, ReadsOneOfSoManyCountedFromOne) {
  EXPECT_EQ(plan::Shard::parse("1/1"), (plan::Shard{1, 1}));
  EXPECT_EQ(plan::Shard::parse("8/8"), (plan::Shard{8, 8}));
}

TEST(Shard, RefusesWhatIsNoShard) {
  for (const auto* text : {"", "x", "1", "1/", "/2", "0/8", "9/8", "-1/8", "1/0", "1/2/3", "1/ 2",
                           "1/1000001", "1/99999999999999999999"}) {
    EXPECT_EQ(plan::Shard::parse(text), std::nullopt) << text;
  }
}

namespace {

/// A quadtree over [-5, 9) x [-3, 6) with a gap, as plans are: sorted, every parent there.
std::vector<plan::Tile> some_plan() {
  std::set<Key> keys;
  for (std::int64_t x = -5; x < 9; ++x) {
    for (std::int64_t y = -3; y < 6; ++y) {
      if (x == 2 && y > 0) continue;
      for (Key key{0, x, y}; key.level < 5; key = key.parent()) keys.insert(key);
    }
  }
  std::vector<plan::Tile> tiles;
  for (const auto& key : keys) tiles.emplace_back(key);
  return tiles;
}

}  // namespace

TEST(Shard, TakesEveryTileOnceAndEvenly) {
  auto tiles = some_plan();
  for (const std::int64_t count : {1, 2, 3, 8, 50, 1000}) {
    std::multiset<Key> all;
    std::size_t fewest = tiles.size(), most = 0;
    for (std::int64_t index = 1; index <= count; ++index) {
      plan::choose({index, count}, tiles);
      EXPECT_TRUE(std::ranges::is_sorted(tiles, {}, &plan::Tile::key));
      std::vector<Key> part;
      for (const auto& tile : tiles) {
        if (tile.ours) part.push_back(tile.key());
      }
      fewest = std::min(fewest, part.size());
      most = std::max(most, part.size());
      all.insert(part.begin(), part.end());
    }
    EXPECT_TRUE(std::ranges::equal(all, tiles, {}, {}, &plan::Tile::key)) << count;
    EXPECT_LE(most - fewest, 1U) << count;
  }
}

TEST(Shard, FollowsTheQuadtreeDepthFirst) {
  const auto tiles = some_plan();
  auto curve = tiles;
  plan::sort_along_curve(curve);
  std::map<Key, std::size_t> place;
  for (std::size_t i = 0; i < curve.size(); ++i) place[curve[i].key()] = i;
  // Below a tile is one run of the curve, which starts with the tile itself.
  for (const auto& tile : tiles) {
    const Key top = tile.key();
    std::size_t count = 0, last = 0;
    for (const auto& other : tiles) {
      const Key key = other.key();
      Key above = key;
      while (above.level < top.level) above = above.parent();
      if (above != top) continue;
      ++count;
      last = std::max(last, place.at(key));
    }
    EXPECT_EQ(last + 1 - place.at(top), count) << top.text();
  }
  // Siblings in the order of Z: x before y.
  EXPECT_LT(place.at({0, 0, 0}), place.at({0, 1, 0}));
  EXPECT_LT(place.at({0, 1, 0}), place.at({0, 0, 1}));
  EXPECT_LT(place.at({0, 0, 1}), place.at({0, 1, 1}));
}
