// Operators on values computed by hand (Paris et al. 2019, section 5.3; DESIGN section 3).
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

constexpr double tiny = 2e-6;

/// At the origin a point of radius R = 10 at distance r has the value g(r): 1 at 0, 0.421875 at 5,
/// 0.046656 at 8.
Node at_distance(double r, double energy = 1) {
  return {dot_at({r, 0, 0}, 10 * half_falloff, energy)};
}
const Node one = at_distance(0), mid = at_distance(5), low = at_distance(8), far = at_distance(50);
constexpr double m = 0.421875, l = 0.046656;

double at_origin(const Node& tree) { return value(tree, {0, 0, 0}); }

TEST(Blend, AddsItsChildrenTimesItsEnergy) {
  EXPECT_NEAR(at_origin({Blend{}, {mid, low, mid}}), 2 * m + l, tiny);
  EXPECT_NEAR(at_origin({Blend{.energy = -2}, {mid, low}}), -2 * (m + l), tiny);
  EXPECT_NEAR(at_origin({Blend{}, {one, at_distance(5, -3)}}), 1 - 3 * m, tiny);
  EXPECT_EQ(at_origin({Blend{}, {}}), 0);
}

TEST(Carve, TakesTheOthersFromTheFirst) {
  EXPECT_NEAR(at_origin({Carve{}, {one, mid, low}}), 1 - m - l, tiny);
  EXPECT_NEAR(at_origin({Carve{}, {far, mid}}), -m, tiny);
}

TEST(Union, IsTheLargest) {
  EXPECT_NEAR(at_origin({Union{}, {low, mid, far}}), m, tiny);
  EXPECT_EQ(at_origin({Union{}, {at_distance(5, -1), far}}), 0);
}

TEST(Intersection, IsTheSmallest) {
  EXPECT_NEAR(at_origin({Intersection{}, {one, mid}}), m, tiny);
  EXPECT_EQ(at_origin({Intersection{}, {one, far}}), 0);
}

TEST(Difference, IsTheSmallerOfTheFirstAndTheComplements) {
  EXPECT_NEAR(at_origin({Difference{}, {one, mid}}), 1 - m, tiny);
  EXPECT_NEAR(at_origin({Difference{}, {mid, low}}), m, tiny);
  EXPECT_EQ(at_origin({Difference{}, {one, one}}), 0);
  EXPECT_EQ(at_origin({Difference{}, {far, mid}}), 0);
}

TEST(SmoothUnion, AddsAFilletWhereItsChildrenMeet) {
  // w = 0.5 (m + m), full fillet w / 4.
  EXPECT_NEAR(at_origin({SmoothUnion{.width = 0.5}, {mid, mid}}), m + 2 * m * 0.5 / 4, tiny);
  // |1 - l| exceeds w = 0.5 (1 + l): a plain maximum.
  EXPECT_NEAR(at_origin({SmoothUnion{.width = 0.5}, {one, low}}), 1, tiny);
  EXPECT_EQ(at_origin({SmoothUnion{.width = 1}, {far, far}}), 0);
  EXPECT_EQ(at_origin({SmoothUnion{.width = 1}, {mid, far}}), at_origin(mid));
}

TEST(SmoothDifference, TakesAFilletAwayWhereItsChildrenMeet) {
  // a = m, 1 - b = 1 - m: w = 0.5 (1 - m + m) = 0.5, gap |m - (1 - m)| = 0.15625.
  const double bite = (0.5 - 0.15625) * (0.5 - 0.15625) / (4 * 0.5);
  EXPECT_NEAR(at_origin({SmoothDifference{.width = 0.5}, {mid, mid}}), m - bite, tiny);
  EXPECT_EQ(at_origin({SmoothDifference{.width = 1}, {mid, far}}), at_origin(mid));
  EXPECT_EQ(at_origin({SmoothDifference{.width = 1}, {far, one}}), 0);
}

TEST(Support, OfAnIntersectionIsWhatItsChildrenShare) {
  const Support s = support({Intersection{}, {one, at_distance(15)}});
  EXPECT_NEAR(s.influence.min.x, 5, 0.01);
  EXPECT_NEAR(s.influence.max.x, 10, 0.01);
  // A negative child is smaller than the others' zeros.
  EXPECT_NEAR(support({Intersection{}, {one, at_distance(15, -1)}}).influence.max.x, 25, 0.01);
}

TEST(Support, OfADifferenceIsItsFirstChilds) {
  EXPECT_NEAR(support({Difference{}, {one, at_distance(15)}}).influence.max.x, 10, 0.01);
  EXPECT_NEAR(support({Difference{}, {one, at_distance(15, 2)}}).influence.max.x, 25, 0.01);
}

TEST(DistanceUnion, LeavesOutWhatHasNoPartInABlock) {
  DistanceUnion joined;
  joined.width = 2;
  FromDistance field;
  field.falloff = 4;
  const Node here{ball({0, 0, 0}, 5, 1)}, there{ball({40, 0, 0}, 5, 1)};
  const auto spheres_at = [&](const Vec3& p) {
    const Node both{field, {{joined, {here, there, here}}}};
    std::vector<std::string> lines;
    const Compiled compiled = compile(both, {p, Box{p, p}.grown(1)});
    if (compiled.kernel) compiled.kernel->explain(0, lines);
    return std::count(lines.begin(), lines.end(), "    sphere");
  };
  EXPECT_EQ(spheres_at({5, 0, 0}), 2);   // the near one, stated twice
  EXPECT_EQ(spheres_at({35, 0, 0}), 1);  // the far one
  const Node alone{field, {{joined, {here, here}}}}, both{field, {{joined, {here, there, here}}}};
  EXPECT_EQ(value(both, {5.2, 0.3, 0}), value(alone, {5.2, 0.3, 0}));
}

}  // namespace
}  // namespace hoodoo::tree
