#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/tiling/surface/lattice.hpp"
#include "tiling/surface/curtain.hpp"

namespace hoodoo::surface::testing {
namespace {

constexpr int units = 256, cells = 32;
constexpr std::int32_t size = cells * units;

/// A tile and its skirts. The mesh has the surface's own points and a made-up look.
struct Hung {
  Surface surface;
  Mesh mesh, skirt;
};
Hung hang_from(const Lattice& lattice, const Function& f, double depth_cells) {
  Hung h;
  const Index low{-32, 64, -16};
  h.surface = polygonize(fill(lattice, low, {low[0] + cells, low[1] + cells, 48}), units);
  h.mesh.points = h.surface.points;
  h.mesh.triangles = h.surface.triangles;
  h.mesh.normals.assign(h.mesh.points.size(), {0, 0, 1});
  h.mesh.colors.assign(h.mesh.points.size(), {1, 2, 3, 255});
  h.mesh.materials.assign(h.mesh.points.size(), 0);
  Curtain curtain;
  curtain.origin = {low[0] * units, low[1] * units, low[2] * units};
  curtain.size = size;
  curtain.depth = depth_cells * units;
  curtain.stride = 0.5 * units;
  curtain.values = [f](std::span<const slice::StepPoint> points) {
    std::vector<float> values;
    for (const auto& p : points) {
      values.push_back(static_cast<float>(
          0.5 + 0.1 * f(Vec3{double(p[0]), double(p[1]), double(p[2])} * (1.0 / units))));
    }
    return values;
  };
  h.skirt = hang(h.surface, h.mesh, curtain);
  return h;
}
Hung hang_from(const Function& f, double depth_cells) {
  return hang_from(lattice_of(f), f, depth_cells);
}

Vec3 point(const Mesh& mesh, std::uint32_t v) {
  const auto& p = mesh.points[v];
  return {double(p[0]), double(p[1]), double(p[2])};
}

double hills(const Vec3& p) { return 12.3 + 5 * std::sin(0.4 * p.x) * std::cos(0.3 * p.y) - p.z; }
/// A roof about three cells thick, with air above and below.
double roof(const Vec3& p) { return 1.5 - std::abs(p.z - 14.2 - 0.2 * p.x + 0.1 * (p.y - 64)); }
double caves(const Vec3& p) { return value_noise(p * (1 / 9.0), 12); }

/// On one side, facing out of the tile, no triangle twice, no vertex without one.
void expect_sound(const Mesh& skirt) {
  std::set<std::array<std::uint32_t, 3>> seen;
  std::set<std::uint32_t> used;
  for (const auto& t : skirt.triangles) {
    const Vec3 a = point(skirt, t[0]), b = point(skirt, t[1]), c = point(skirt, t[2]);
    const Vec3 n = cross(b - a, c - a);
    const auto on = [&](int axis, double at) {
      return a[axis] == at && b[axis] == at && c[axis] == at;
    };
    const bool faces_out = (on(0, 0) && n.x < 0) || (on(0, size) && n.x > 0) ||
                           (on(1, 0) && n.y < 0) || (on(1, size) && n.y > 0);
    EXPECT_TRUE(faces_out);
    auto sorted = t;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_TRUE(seen.insert(sorted).second);
    used.insert(t.begin(), t.end());
  }
  EXPECT_EQ(used.size(), skirt.points.size());
  for (const auto& p : skirt.points) {
    EXPECT_TRUE(p[0] >= 0 && p[0] <= size && p[1] >= 0 && p[1] <= size);
  }
}

/// Directed edges by position.
using EdgeSet = std::set<std::pair<std::array<std::int32_t, 3>, std::array<std::int32_t, 3>>>;
EdgeSet edges_of(const std::vector<std::array<std::int32_t, 3>>& points,
                 const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  EdgeSet edges;
  for (const auto& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert({points[t[k]], points[t[(k + 1) % 3]]});
  }
  return edges;
}

TEST(Skirts, HangFromEveryEdgeOfTheBorderCurve) {
  for (const auto& f : {Function(hills), Function(caves)}) {
    const auto h = hang_from(f, 2);
    expect_sound(h.skirt);
    const auto surface = edges_of(h.surface.points, h.surface.triangles);
    const auto skirt = edges_of(h.skirt.points, h.skirt.triangles);
    int rim = 0, bare = 0;
    for (const auto& [a, b] : surface) {
      const bool on_side = (a[0] == b[0] && (a[0] == 0 || a[0] == size)) ||
                           (a[1] == b[1] && (a[1] == 0 || a[1] == size));
      if (!on_side || surface.contains({b, a})) continue;
      ++rim;
      if (!skirt.contains({b, a})) ++bare;
    }
    EXPECT_GT(rim, 100);
    // Where the solid is thinner than a step or the curve folds there is no room for one.
    EXPECT_LE(bare, rim / 100);
  }
}

TEST(Skirts, AreAsDeepAsWantedWhereTheSolidGoesOn) {
  const auto h = hang_from(hills, 2);
  const std::set<std::array<std::int32_t, 3>> hung(h.skirt.points.begin(), h.skirt.points.end());
  int corners = 0;
  for (const auto& [x, y, z] : h.surface.points) {
    if (x % size != 0 || y % size != 0) continue;
    ++corners;
    EXPECT_TRUE(hung.contains({x, y, z}));
    EXPECT_TRUE(hung.contains({x, y, z - 2 * units}));
  }
  EXPECT_EQ(corners, 4);
}

TEST(Skirts, EndInTheMiddleOfAThinRoof) {
  const auto h = hang_from(roof, 8);
  expect_sound(h.skirt);
  ASSERT_GT(h.skirt.triangles.size(), 200U);
  for (std::uint32_t v = 0; v < h.skirt.points.size(); ++v) {
    const Vec3 p = point(h.skirt, v) * (1.0 / units) + Vec3{-32, 64, -16};
    EXPECT_GT(roof(p), -0.1);
    EXPECT_LT(roof(p), 1.6);
  }
}

TEST(Skirts, AreMissingAlongTheEdgeOfTheWorld) {
  auto lattice = lattice_of(hills);
  lattice.in_world = [](std::int64_t i, std::int64_t j) {
    return i < 0 && !(i > -10 && j > 80);  // ends at the east side, with a hole at the north-east
  };
  const auto h = hang_from(lattice, hills, 2);
  expect_sound(h.skirt);
  ASSERT_FALSE(h.skirt.triangles.empty());
  std::set<std::array<std::int32_t, 3>> at_edge;
  for (std::size_t i = 0; i < h.surface.points.size(); ++i) {
    if ((h.surface.planes[i] & world_edge) != 0) at_edge.insert(h.surface.points[i]);
  }
  EXPECT_GT(at_edge.size(), 40U);
  for (const auto& [a, b] : edges_of(h.skirt.points, h.skirt.triangles)) {
    EXPECT_FALSE(at_edge.contains(a) && at_edge.contains(b));
  }
}

TEST(Skirts, CarryTheLookOfTheSurfaceAboveThem) {
  const auto h = hang_from(hills, 2);
  EXPECT_EQ(h.skirt.normals.size(), h.skirt.points.size());
  EXPECT_EQ(h.skirt.materials.size(), h.skirt.points.size());
  for (const auto& color : h.skirt.colors)
    EXPECT_EQ(color, (std::array<std::uint8_t, 4>{1, 2, 3, 255}));
}

}  // namespace
}  // namespace hoodoo::surface::testing
