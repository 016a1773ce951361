#include "engine/tree/reach.hpp"

#include <gtest/gtest.h>

#include "engine/tree/region.hpp"

namespace hoodoo::tree {
namespace {

Box column(double x, double y, double side) { return {{x, y, -1000}, {x + side, y + side, 1000}}; }

Node balls(const std::vector<Ball>& list) {
  PointSet set;
  set.balls = Balls(list);
  return {set, {}};
}

TEST(Reach, OfBallsIsThatOfThoseOverTheColumn) {
  // A point's field ends at radius / 0.4542.
  const Node many = balls({{{0, 0, 10}, 1, 1}, {{3, 0, 50}, 1, -1}, {{100, 0, 500}, 1, 1}});
  const double far = 1 / half_falloff;
  const Reach both = reach_over(many, column(0, 0, 2));
  EXPECT_NEAR(both.z.low, 10 - far, 0.02);
  EXPECT_NEAR(both.z.high, 50 + far, 0.02);
  EXPECT_LE(both.z.low, 10 - far);
  EXPECT_GE(both.z.high, 50 + far);
  EXPECT_NEAR(reach_over(many, column(99, -1, 2)).z.low, 500 - far, 0.02);
  EXPECT_TRUE(reach_over(many, column(40, 0, 2)).empty());
}

TEST(Reach, OfASumOrUnionIsThatOfItsParts) {
  const Node low = balls({{{0, 0, 10}, 1, 1}}), high = balls({{{50, 0, 90}, 1, 1}});
  for (const Node& any : {Node{Blend{}, {low, high}}, Node{Union{}, {low, high}}}) {
    EXPECT_LT(reach_over(any, column(0, 0, 1)).z.high, 20);
    EXPECT_GT(reach_over(any, column(50, 0, 1)).z.low, 80);
    EXPECT_TRUE(reach_over(any, column(25, 0, 1)).empty());
    EXPECT_GT(reach_over(any, column(0, 0, 60)).z.high, 90);
  }
}

TEST(Reach, OfAnyOtherTreeIsItsInfluence) {
  Sphere sphere;
  sphere.center = Vec3{0, 0, 5};
  sphere.radius = 2;
  const Node tree{sphere, {}};
  const Box influence = support(tree).influence;
  const Reach reach = reach_over(tree, column(0, 0, 1));
  EXPECT_EQ(reach.z.low, influence.min.z);
  EXPECT_EQ(reach.z.high, influence.max.z);
  EXPECT_TRUE(reach_over(tree, column(influence.max.x + 1, 0, 1)).empty());
}

}  // namespace
}  // namespace hoodoo::tree
