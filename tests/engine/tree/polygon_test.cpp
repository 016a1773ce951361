#include "engine/tree/polygon.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hoodoo::tree {
namespace {

// An L: the square [0,4]^2 without [2,4]^2.
const Polygon shape{{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}};

TEST(EdgeDistance, IsPositiveInsideAndNegativeOutside) {
  EXPECT_DOUBLE_EQ(edge_distance(shape, 1, 1).d, 1);
  EXPECT_DOUBLE_EQ(edge_distance(shape, 1.5, 2.5).d, 0.5);
  EXPECT_DOUBLE_EQ(edge_distance(shape, 3, 3).d, -1);
  EXPECT_DOUBLE_EQ(edge_distance(shape, -3, -4).d, -5);
  EXPECT_DOUBLE_EQ(edge_distance(shape, 1.4, 1.3).d, 0.5 * std::sqrt(4 * (0.36 + 0.49)));
}

TEST(EdgeDistance, HasAGradientThatPointsInward) {
  const auto inside = edge_distance(shape, 0.5, 2);
  EXPECT_DOUBLE_EQ(inside.dx, 1);
  EXPECT_DOUBLE_EQ(inside.dy, 0);
  const auto outside = edge_distance(shape, -3, -4);
  EXPECT_DOUBLE_EQ(outside.dx, 0.6);
  EXPECT_DOUBLE_EQ(outside.dy, 0.8);
}

TEST(EdgeDistance, HasTheInwardNormalOnTheEdgeItself) {
  for (const bool clockwise : {false, true}) {
    Polygon p = shape;
    if (clockwise) std::reverse(p.begin(), p.end());
    const auto on = edge_distance(p, 0, 3);
    EXPECT_DOUBLE_EQ(on.d, 0);
    EXPECT_DOUBLE_EQ(on.dx, 1);
    EXPECT_DOUBLE_EQ(on.dy, 0);
  }
}

TEST(EdgeDistance, OverABoxContainsItsValues) {
  const Box box{{-1, 0.5, 0}, {3, 3, 0}};
  const Interval all = edge_distance(shape, box);
  for (double x = -1; x <= 3; x += 0.125) {
    for (double y = 0.5; y <= 3; y += 0.125)
      EXPECT_TRUE(all.contains(edge_distance(shape, x, y).d));
  }
}

TEST(Bounds, OfAPolygonAreUnboundedInHeight) {
  const Box box = bounds(shape);
  EXPECT_EQ(box.min.x, 0);
  EXPECT_EQ(box.max.y, 4);
  EXPECT_EQ(box.max.z, Box::infinity);
}

}  // namespace
}  // namespace hoodoo::tree
