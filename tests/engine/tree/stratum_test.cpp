#include "engine/tree/stratum.hpp"

#include <gmock/gmock.h>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

using testing::ElementsAre;

/// A seam at height z: rho falls from `energy` to 0 across 10 m.
Node seam(const std::string& name, double z, double energy, double level = 0.5) {
  Plane plane;
  plane.point = Vec3{0, 0, z};
  plane.falloff = 10;
  plane.energy = energy;
  return {Stratum{name, level}, {{plane, {}}}};
}

bool prevails(const Node& geology, const std::string& name, const Vec3& at) {
  const auto tree = where_prevails(geology, name);
  return tree && value(*tree, at) >= 0.5;
}

TEST(Stratum, IsItsChild) {
  const Node named = seam("coal", 4, -0.7);
  for (const double z : {-7.0, 0.0, 4.0, 6.5, 20.0}) {
    EXPECT_EQ(value(named, {1, 2, z}), value(named.children[0], {1, 2, z}));
  }
}

TEST(Stratum, PrevailsOutToWhereItsChildHasHalfItsPeak) {
  const Node geology{Blend{}, {{Strata{}, {}}, seam("coal", 0, -0.7), seam("chalk", 50, 2)}};
  EXPECT_TRUE(prevails(geology, "coal", {3, 0, 0}));
  EXPECT_TRUE(prevails(geology, "coal", {3, 0, 4.5}));  // half of it at 0.4542 * 10 m
  EXPECT_FALSE(prevails(geology, "coal", {3, 0, 4.6}));
  EXPECT_FALSE(prevails(geology, "coal", {3, 0, 50}));
  EXPECT_TRUE(prevails(geology, "chalk", {3, 0, 46}));
  EXPECT_FALSE(where_prevails(geology, "salt"));
  EXPECT_THAT(strata_of(geology), ElementsAre("coal", "chalk"));
}

TEST(Stratum, PrevailsAsFarAsItsLevelSays) {
  // g = 0.25 where (u/R)^2 = 1 - 0.25^(1/3): u = 6.083 m.
  const Node geology = seam("coal", 0, 1, 0.25);
  EXPECT_TRUE(prevails(geology, "coal", {0, 0, 6.05}));
  EXPECT_FALSE(prevails(geology, "coal", {0, 0, 6.12}));
}

TEST(Stratum, MovesWithWhatMovesTheGeology) {
  Translate up;
  up.by = {0, 0, 100};
  HalfSpace east;
  east.normal = {-1, 0, 0};
  east.falloff = 1;
  Fault fault;
  fault.by = {0, 0, 30};
  const Node geology{fault, {{up, {{Blend{3}, {seam("coal", 0, 1), {Strata{}, {}}}}}}, {east, {}}}};
  EXPECT_TRUE(prevails(geology, "coal", {-50, 0, 100}));
  EXPECT_FALSE(prevails(geology, "coal", {50, 0, 100}));
  EXPECT_TRUE(prevails(geology, "coal", {50, 0, 130}));
}

TEST(Stratum, UnitesAllOfOneName) {
  const Node geology{Blend{}, {seam("coal", 0, 1), seam("coal", 40, -1)}};
  EXPECT_TRUE(prevails(geology, "coal", {0, 0, 2}));
  EXPECT_TRUE(prevails(geology, "coal", {0, 0, 42}));
  EXPECT_FALSE(prevails(geology, "coal", {0, 0, 20}));
}

TEST(Stratum, OfNothingPrevailsNowhere) {
  EXPECT_FALSE(where_prevails(seam("coal", 0, 0), "coal"));
}

}  // namespace
}  // namespace hoodoo::tree
