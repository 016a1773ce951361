#include "tiling/lod/lod.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/base/box.hpp"
#include "tests/tiling/lod/shapes.hpp"
#include "tiling/lod/buckets.hpp"

namespace hoodoo::lod {
namespace {

using shapes::height_field;
using shapes::Hills;
using shapes::torus;
using surface::Surface;

std::vector<Vec3> points_of(const Surface& surface) {
  std::vector<Vec3> points;
  for (const auto& [x, y, z] : surface.points) {
    points.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
  }
  return points;
}

/// Largest distance of corners and centres of `from` from `to`, by looking at every triangle.
double slow_distance(const Surface& from, const Surface& to) {
  const auto p = points_of(from), q = points_of(to);
  double worst = 0;
  const auto look = [&](const Vec3& at) {
    double best = Box::infinity;
    for (const auto& [a, b, c] : to.triangles)
      best = std::min(best, distance2(at, q[a], q[b], q[c]));
    worst = std::max(worst, best);
  };
  for (const auto& at : p) look(at);
  for (const auto& [a, b, c] : from.triangles) look((p[a] + p[b] + p[c]) * (1.0 / 3));
  return std::sqrt(worst);
}

class Ground : public testing::TestWithParam<std::tuple<int, double>> {};
INSTANTIATE_TEST_SUITE_P(OfManyKinds, Ground,
                         testing::Combine(testing::Values(2, 4, 7),
                                          testing::Values(10.0, 25.6, 128.0, 400.0)));

TEST_P(Ground, KeepsBordersTopologyAndTheErrorAllowed) {
  const auto [octaves, error] = GetParam();
  for (const double boundary : {-1.0, 15.0}) {
    const Surface before =
        height_field({.side = 32, .octaves = octaves, .height = 30, .boundary = boundary});
    ASSERT_TRUE(is_manifold(before));
    const auto [after, measured] = simplify(before, error, shapes::units);
    EXPECT_TRUE(is_manifold(after));
    EXPECT_TRUE(is_manifold(after, &before));
    EXPECT_LE(measured, error);
    EXPECT_LE(slow_distance(before, after), measured + 1e-6);
    EXPECT_LE(slow_distance(after, before), measured + 1e-6);
    const std::set points(before.points.begin(), before.points.end());
    for (const auto& p : after.points) EXPECT_TRUE(points.contains(p));
  }
}

TEST_P(Ground, IsNotFolded) {
  const auto [octaves, error] = GetParam();
  const auto simplified =
      simplify(height_field({.side = 64, .octaves = octaves, .height = 30}), error, shapes::units);
  const auto p = points_of(simplified.surface);
  for (const auto& [a, b, c] : simplified.surface.triangles) {
    // On steep ground a narrow triangle may lean over by a little.
    EXPECT_GT(normalized(cross(p[b] - p[a], p[c] - p[a])).z, -0.35);
  }
}

TEST(Simplify, RemovesMostOfSmoothGround) {
  const Surface before = height_field({.side = 128, .octaves = 2});
  EXPECT_LT(simplify(before, 128, shapes::units).surface.triangles.size(),
            before.triangles.size() / 10);
}

TEST(Simplify, IsQuickOnLevelGround) {
  const Surface before = height_field({.side = 256, .octaves = 0});
  const auto simplified = simplify(before, 25, shapes::units);
  EXPECT_LT(simplified.surface.triangles.size(), before.triangles.size() / 30);
  EXPECT_TRUE(is_manifold(simplified.surface, &before));
}

TEST(Simplify, KeepsTheHoleOfATorus) {
  const Surface before = torus(200, 80, 30, 9);
  for (const double error : {12.0, 60.0, 300.0}) {
    const auto [after, measured] = simplify(before, error, shapes::units);
    EXPECT_LT(after.triangles.size(), before.triangles.size());
    EXPECT_TRUE(is_manifold(after, &before));
    EXPECT_LE(measured, error);
  }
}

TEST(Simplify, GivesTheSameEveryTime) {
  const Surface before = height_field({.side = 64, .boundary = 10});
  const auto a = simplify(before, 60, shapes::units), b = simplify(before, 60, shapes::units);
  EXPECT_EQ(a.surface.points, b.surface.points);
  EXPECT_EQ(a.surface.triangles, b.surface.triangles);
  EXPECT_EQ(a.surface.materials, b.surface.materials);
  EXPECT_EQ(a.error, b.error);
}

TEST(Simplify, LeavesAloneWhatItMayNotChange) {
  const Surface before = height_field({.side = 16});
  EXPECT_EQ(simplify(before, 0, shapes::units).surface.triangles, before.triangles);
  EXPECT_TRUE(simplify({}, 10, shapes::units).surface.triangles.empty());
}

TEST(Simplify, KeepsEachTriangleOfOneMaterialNearWhereThatMaterialWas) {
  const Surface before = height_field({.side = 48, .boundary = 15});
  const auto [after, measured] = simplify(before, 100, shapes::units);
  for (std::uint16_t material = 0; material < 2; ++material) {
    const auto only = [&](const Surface& all) {
      Surface part = all;
      part.triangles.clear();
      for (std::size_t t = 0; t < all.triangles.size(); ++t) {
        if (all.materials[t] == material) part.triangles.push_back(all.triangles[t]);
      }
      return part;
    };
    Surface now = only(after);
    const Surface was = only(before);
    ASSERT_FALSE(now.triangles.empty());
    const auto p = points_of(now), q = points_of(was);
    const Buckets buckets(q, was.triangles, 400);
    for (const auto& [a, b, c] : now.triangles) {
      std::uint32_t hint = 0;
      EXPECT_LE(buckets.beyond((p[a] + p[b] + p[c]) * (1.0 / 3), 0, hint), 200.0 * 200.0);
    }
  }
}

/// Both tiles' edges by position, with the number of faces at each.
std::map<std::pair<std::array<std::int32_t, 3>, std::array<std::int32_t, 3>>, int> edges_of(
    const Surface& surface, std::int32_t east) {
  std::map<std::pair<std::array<std::int32_t, 3>, std::array<std::int32_t, 3>>, int> edges;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      auto a = surface.points[t[i]], b = surface.points[t[(i + 1) % 3]];
      a[0] += east;
      b[0] += east;
      ++edges[std::minmax(a, b)];
    }
  }
  return edges;
}

TEST(Simplify, LeavesNeighboursThatMeetWithTwoFacesOnEveryEdge) {
  constexpr int side = 48;
  const auto west =
      simplify(height_field({.side = side, .octaves = 6, .height = 30}), 200, shapes::units);
  const auto east = simplify(height_field({.side = side, .octaves = 6, .height = 30, .x0 = side}),
                             200, shapes::units);
  auto edges = edges_of(west.surface, 0);
  for (const auto& [edge, faces] : edges_of(east.surface, side * shapes::units)) {
    edges[edge] += faces;
  }
  int shared = 0;
  for (const auto& [edge, faces] : edges) {
    EXPECT_LE(faces, 2);
    if (edge.first[0] == side * shapes::units && edge.second[0] == side * shapes::units) {
      EXPECT_EQ(faces, 2);
      ++shared;
    }
  }
  EXPECT_EQ(shared, side + 1);
}

TEST(Manifold, SeesWhatIsWrong) {
  const Surface sound = height_field({.side = 16});
  const auto broken = [&](auto change) {
    Surface surface = sound;
    change(surface);
    return !is_manifold(surface);
  };
  EXPECT_TRUE(is_manifold(sound));
  EXPECT_TRUE(broken([](Surface& s) {  // a hole
    s.triangles.erase(s.triangles.begin() + 200);
    s.materials.pop_back();
  }));
  EXPECT_TRUE(broken([](Surface& s) { std::swap(s.triangles[200][0], s.triangles[200][1]); }));
  EXPECT_TRUE(broken([](Surface& s) { s.triangles[200][0] = s.triangles[200][1]; }));
  EXPECT_TRUE(broken([](Surface& s) {
    s.triangles.push_back(s.triangles[200]);
    s.materials.push_back(0);
  }));
  EXPECT_TRUE(broken([](Surface& s) { s.points[100] = s.points[101]; }));
  Surface moved = sound;
  ++moved.points[3][2];  // on the border: sound by itself, not the same border
  EXPECT_TRUE(is_manifold(moved));
  EXPECT_FALSE(is_manifold(moved, &sound));
  Surface other = sound;
  other.materials[0] = 1;
  EXPECT_FALSE(is_manifold(other, &sound));
}

TEST(WorldEdges, AreThoseBetweenMarkedVertices) {
  const auto count = [](std::uint8_t world) {
    return world_edges(height_field({.side = 16, .world = world}));
  };
  EXPECT_EQ(count(0), 0U);
  EXPECT_EQ(count(surface::west), 17U);
  EXPECT_EQ(count(surface::west | surface::north), 34U);
}

}  // namespace
}  // namespace hoodoo::lod
