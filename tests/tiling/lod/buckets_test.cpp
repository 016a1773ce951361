#include "tiling/lod/buckets.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/base/box.hpp"
#include "engine/base/random.hpp"
#include "tiling/lod/deviation.hpp"

namespace hoodoo::lod {
namespace {

double unit(std::uint64_t a, std::uint64_t b) { return unit_real(random_bits(a, b)); }

Vec3 random_point(std::uint64_t k, double size) {
  return {size * unit(k, 0), size * unit(k, 1), size * unit(k, 2)};
}

/// Triangles of many sizes and directions, one tenth of them segments.
struct Soup {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  explicit Soup(std::uint64_t seed) {
    for (std::uint32_t t = 0; t < 300; ++t) {
      const Vec3 at = random_point(seed + 4 * t, 100);
      const double size = t % 20 == 0 ? 60 : 1 + 6 * unit(seed + t, 9);
      for (std::uint64_t c = 1; c < 4; ++c) {
        points.push_back(at + random_point(seed + 4 * t + c, size));
      }
      triangles.push_back({3 * t, 3 * t + 1, t % 10 == 0 ? 3 * t + 1 : 3 * t + 2});
    }
  }
  double distance2_to(const Vec3& p) const {
    double best = Box::infinity;
    for (const auto& [a, b, c] : triangles) {
      best = std::min(best, distance2(p, points[a], points[b], points[c]));
    }
    return best;
  }
};

TEST(Distance, OfPointsAroundATriangleIsRight) {
  const Vec3 a{0, 0, 0}, b{4, 0, 0}, c{0, 4, 0};
  EXPECT_EQ(distance2({1, 1, 3}, a, b, c), 9);    // face
  EXPECT_EQ(distance2({2, -2, 0}, a, b, c), 4);   // side ab
  EXPECT_EQ(distance2({-3, 1, 4}, a, b, c), 25);  // side ca
  EXPECT_EQ(distance2({4, 4, 0}, a, b, c), 8);    // side bc
  EXPECT_EQ(distance2({-1, -1, 1}, a, b, c), 3);  // corner a
  EXPECT_EQ(distance2({6, -1, 0}, a, b, c), 5);   // corner b
  EXPECT_EQ(distance2({-1, 6, 0}, a, b, c), 5);   // corner c
  EXPECT_EQ(distance2({2, 3, 0}, a, b, b), 9);    // a segment
  EXPECT_EQ(distance2({7, 0, 4}, a, b, b), 25);
}

TEST(Buckets, AgreeWithLookingAtEveryTriangle) {
  for (const std::uint64_t seed : {1000U, 50000U, 90000U}) {
    const Soup soup(seed);
    for (const double side : {0.5, 3.0, 40.0}) {
      const Buckets buckets(soup.points, soup.triangles, side);
      std::uint32_t hint = 0;
      for (std::uint64_t k = 0; k < 500; ++k) {
        const Vec3 p = random_point(7'000'000 + k, 160) - Vec3{30, 30, 30};
        const double expected = soup.distance2_to(p);
        EXPECT_DOUBLE_EQ(buckets.beyond(p, 0, hint), expected) << "seed " << seed;
        EXPECT_DOUBLE_EQ(buckets.beyond(p, 1.5 * expected, hint), 1.5 * expected);
        EXPECT_DOUBLE_EQ(buckets.beyond(p, 0.5 * expected, hint), expected);
      }
    }
  }
}

TEST(Buckets, FindTrianglesThatFaceOneWay) {
  const std::vector<Vec3> points{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 1}, {9, 0, 1}, {0, 9, 1}};
  const std::vector<Triangle> triangles{{0, 1, 2}, {3, 5, 4}};  // up at 0, down at 1
  const Buckets buckets(points, triangles, 2);
  std::uint32_t hint = 0;
  EXPECT_TRUE(buckets.faces({2, 2, 1}, 1.1, {0, 0, 1}, hint));
  EXPECT_FALSE(buckets.faces({2, 2, 1}, 0.9, {0, 0, 1}, hint));
  EXPECT_TRUE(buckets.faces({2, 2, 1}, 0.9, {0, 0, -1}, hint));
}

TEST(Samples, LeaveNoPointFartherThanTheSpacingAndAvoidCorners) {
  const Vec3 a{0, 0, 0}, b{10, 0, 0}, c{0, 7, 3};
  std::vector<Vec3> samples;
  for_each_sample(a, b, c, 1.5, [&](const Vec3& p) { samples.push_back(p); });
  for (const auto& corner : {a, b, c}) {
    EXPECT_EQ(std::ranges::count(samples, corner), 0);
    samples.push_back(corner);
  }
  for (std::uint64_t k = 0; k < 300; ++k) {
    double u = unit(k, 5), v = unit(k, 6);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 p = a + (b - a) * u + (c - a) * v;
    double best = Box::infinity;
    for (const auto& s : samples) best = std::min(best, length(p - s));
    EXPECT_LE(best, 1.5);
  }
}

TEST(Farthest, IsTheLargestDistanceWithinTheLimitAndAtLeastTheFloor) {
  const Soup soup(4000);
  const Buckets buckets(soup.points, soup.triangles, 5);
  Farthest farthest(8, 0.5);
  double expected = 0.5;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const Vec3 p = random_point(k, 120);
    const double d = std::sqrt(soup.distance2_to(p));
    EXPECT_EQ(farthest.look(p, buckets), d <= 8);
    if (d <= 8) expected = std::max(expected, d);
  }
  EXPECT_DOUBLE_EQ(farthest.distance(), expected);
  EXPECT_EQ(Farthest(8, 0.5).distance(), 0.5);
}

}  // namespace
}  // namespace hoodoo::lod
