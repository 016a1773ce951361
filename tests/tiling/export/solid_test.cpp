#include "tiling/export/solid.hpp"

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

namespace hoodoo::exporting {
namespace {

using tileset::Patch;

/// Two triangles over [west, east] x [south, north] at a height that falls to the east by `slope`.
void add_plate(Patch& patch, double west, double south, double east, double north, double height,
               double slope = 0, bool down = false) {
  const auto first = static_cast<std::uint32_t>(patch.points.size());
  const auto at = [&](double x, double y) { return Vec3{x, y, height - slope * (x - west)}; };
  patch.points.insert(patch.points.end(),
                      {at(west, south), at(east, south), at(east, north), at(west, north)});
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (down) std::swap(b, c);
    patch.triangles.push_back({first + a, first + b, first + c});
  };
  add(0, 1, 2);
  add(0, 2, 3);
}

/// What the triangles enclose, by the divergence theorem, if they are closed and turned outward.
double volume(const Patch& patch) {
  double six = 0;
  for (const auto& [a, b, c] : patch.triangles) {
    six += dot(patch.points[a], cross(patch.points[b], patch.points[c]));
  }
  return six / 6;
}

/// The sum of area vectors: none for a closed surface.
Vec3 opening(const Patch& patch) {
  Vec3 sum;
  for (const auto& [a, b, c] : patch.triangles) {
    const Vec3& p = patch.points[a];
    sum = sum + cross(patch.points[b] - p, patch.points[c] - p) * 0.5;
  }
  return sum;
}

TEST(Close, MakesABoxOfAPlate) {
  Patch patch;
  add_plate(patch, 10, 20, 14, 25, 3);
  EXPECT_TRUE(close(patch, -2));
  EXPECT_DOUBLE_EQ(volume(patch), 4 * 5 * 5);
  EXPECT_EQ(opening(patch), Vec3{});
  EXPECT_EQ(patch.triangles.size(), 12U);
}

TEST(Close, FollowsASlope) {
  Patch patch;
  add_plate(patch, 0, 0, 4, 2, 4, 1);
  EXPECT_TRUE(close(patch, 0));
  EXPECT_DOUBLE_EQ(volume(patch), 4 * 4 / 2 * 2);
}

TEST(Close, LeavesAMouthOfACaveOpen) {
  Patch patch;
  add_plate(patch, 0, 0, 4, 4, 9);           // the ground
  add_plate(patch, 0, 0, 4, 4, 6, 0, true);  // the roof of a cave through and through
  add_plate(patch, 0, 0, 4, 4, 5);           // its floor
  EXPECT_TRUE(close(patch, 0));
  EXPECT_DOUBLE_EQ(volume(patch), 16 * (9 - 6 + 5));
  EXPECT_EQ(opening(patch), Vec3{});
}

TEST(Close, KeepsABodyInTheAirOffTheFloor) {
  Patch patch;
  add_plate(patch, 0, 0, 4, 4, 1);
  add_plate(patch, 0, 0, 4, 4, 20);
  add_plate(patch, 0, 0, 4, 4, 18, 0, true);
  EXPECT_TRUE(close(patch, 0));
  EXPECT_DOUBLE_EQ(volume(patch), 16 * (1 + 2));
}

TEST(Close, LeavesAHoleOfTheWorldOpen) {
  Patch patch;  // a frame of 1 m around a hole of 2 x 2 m
  add_plate(patch, 0, 0, 4, 1, 1);
  add_plate(patch, 0, 3, 4, 4, 1);
  add_plate(patch, 0, 1, 1, 3, 1);
  add_plate(patch, 3, 1, 4, 3, 1);
  EXPECT_TRUE(close(patch, 0));
  EXPECT_DOUBLE_EQ(volume(patch), 12);
  EXPECT_EQ(opening(patch), Vec3{});
}

TEST(Close, LeavesAClosedSurfaceAsItIs) {
  Patch patch;
  add_plate(patch, 0, 0, 1, 1, 1);
  close(patch, 0);
  // Its corners meet now.
  Patch welded;
  for (const auto& t : patch.triangles) {
    lod::Triangle named{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto at = std::ranges::find(welded.points, patch.points[t[c]]);
      named[c] = static_cast<std::uint32_t>(at - welded.points.begin());
      if (at == welded.points.end()) welded.points.push_back(patch.points[t[c]]);
    }
    welded.triangles.push_back(named);
  }
  EXPECT_FALSE(close(welded, -5));
  EXPECT_EQ(welded.triangles.size(), 12U);
}

TEST(Close, RefusesAnEdgeThatLiesInNoUprightPlane) {
  Patch patch;
  patch.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  patch.triangles = {{0, 1, 2}};
  EXPECT_THROW(close(patch, -1), Error);
}

}  // namespace
}  // namespace hoodoo::exporting
