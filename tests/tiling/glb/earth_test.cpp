#include "tiling/glb/earth.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "engine/base/error.hpp"

namespace hoodoo::glb {
namespace {

/// Points a step apart at least, far from the scene's origin, and normals all around.
Content content_at(const std::array<std::int64_t, 3>& origin) {
  std::mt19937 random(3);
  std::uniform_int_distribution<std::int32_t> place(0, 128 * 256), beside(-1, 1);
  std::normal_distribution<double> any;
  Content content;
  content.step = 1.0 / 256;
  content.origin = origin;
  content.materials.push_back({"rock", {1, 2, 3}, 0, 1, 0.5});
  std::set<std::array<std::int32_t, 3>> taken;
  while (taken.size() < 900) {
    const std::array<std::int32_t, 3> p{place(random), place(random), place(random)};
    taken.insert(p);
    taken.insert({p[0] + beside(random), p[1] + beside(random), p[2] + beside(random)});
  }
  auto& mesh = content.surface;
  for (const auto& p : taken) {
    const Vec3 n = normalized({any(random), any(random), any(random)});
    mesh.points.push_back(p);
    mesh.normals.push_back(
        {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
    mesh.colors.push_back({9, 9, 9, 255});
    mesh.materials.push_back(0);
  }
  for (std::uint32_t i = 0; i + 2 < mesh.points.size(); i += 3) {
    mesh.triangles.push_back({i, i + 1, i + 2});
  }
  mesh.points.resize(mesh.triangles.size() * 3);
  mesh.normals.resize(mesh.points.size());
  mesh.colors.resize(mesh.points.size());
  mesh.materials.resize(mesh.points.size());
  return content;
}

double degrees_between(const Vec3f& a, const Vec3f& b) {
  const auto d = [](float v) { return static_cast<double>(v); };
  return 57.3 * length(cross({d(a.x), d(a.y), d(a.z)}, {d(b.x), d(b.y), d(b.z)}));
}

TEST(TilesOnTheEarth, ComeBackStepByStepFromTheirFiles) {
  const dem::Earth earth({"EPSG:32632", 1, 350'000, 5'100'000, "EPSG:5773"});
  for (const char* profile : {"plain", "draco", "meshopt"}) {
    const auto content = content_at({40'000 * 256 + 17, 49'000 * 256, 1800 * 256});
    const auto laid = on_earth(content, earth);
    const auto found =
        from_earth(read(write(laid, profile), laid.step, "tile"), earth, content.step, "tile");
    ASSERT_EQ(found.surface.triangles.size(), content.surface.triangles.size());
    ASSERT_EQ(found.step, content.step);
    // Draco reorders: points are told by where they are.
    std::map<std::array<std::int64_t, 3>, Vec3f> wanted, got;
    const auto put = [](auto& all, const auto& origin, const auto& points, const auto& normals) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        all[{origin[0] + points[i][0], origin[1] + points[i][1], origin[2] + points[i][2]}] =
            normals[i];
      }
    };
    put(wanted, content.origin, content.surface.points, content.surface.normals);
    put(got, found.origin, found.surface.points, found.surface.normals);
    ASSERT_EQ(wanted.size(), got.size());
    for (const auto& [place, normal] : wanted) {
      ASSERT_TRUE(got.contains(place)) << profile;
      EXPECT_LT(degrees_between(got.at(place), normal), 0.5);
    }
  }
}

TEST(TilesOnTheEarth, RefuseOtherPoints) {
  const dem::Earth earth({"EPSG:32632", 1, 350'000, 5'100'000, "ellipsoid"});
  const auto content = content_at({0, 0, 0});
  auto laid = on_earth(content, earth);
  for (auto& p : laid.surface.points) p[0] += finer / 2;  // between two steps of the lattice
  const auto tile = read(write(laid, "plain"), laid.step, "tile");
  EXPECT_THROW(from_earth(tile, earth, content.step, "tile"), Error);
}

}  // namespace
}  // namespace hoodoo::glb
