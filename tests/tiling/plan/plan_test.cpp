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
std::vector<Key> some_plan() {
  std::set<Key> keys;
  for (std::int64_t x = -5; x < 9; ++x) {
    for (std::int64_t y = -3; y < 6; ++y) {
      if (x == 2 && y > 0) continue;
      for (Key key{0, x, y}; key.level < 5; key = key.parent()) keys.insert(key);
    }
  }
  return {keys.begin(), keys.end()};
}

}  // namespace

TEST(Shard, TakesEveryTileOnceAndEvenly) {
  const auto tiles = some_plan();
  for (const std::int64_t count : {1, 2, 3, 8, 50, 1000}) {
    std::multiset<Key> all;
    std::size_t fewest = tiles.size(), most = 0;
    for (std::int64_t index = 1; index <= count; ++index) {
      const auto part = plan::tiles_of({index, count}, tiles);
      fewest = std::min(fewest, part.size());
      most = std::max(most, part.size());
      all.insert(part.begin(), part.end());
    }
    EXPECT_TRUE(std::ranges::equal(all, tiles)) << count;
    EXPECT_LE(most - fewest, 1U) << count;
  }
}

TEST(Shard, FollowsTheQuadtreeDepthFirst) {
  const auto tiles = some_plan();
  const auto curve = plan::tiles_of({1, 1}, tiles);
  std::map<Key, std::size_t> place;
  for (std::size_t i = 0; i < curve.size(); ++i) place[curve[i]] = i;
  // Below a tile is one run of the curve, which starts with the tile itself.
  for (const auto& top : tiles) {
    std::size_t count = 0, last = 0;
    for (const auto& key : tiles) {
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
