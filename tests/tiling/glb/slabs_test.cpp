#include "tiling/glb/slabs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <tuple>

#include "tests/tiling/lod/meshes.hpp"

namespace hoodoo::glb {
namespace {

using shapes::mesh_of;
using shapes::skirt_of;

struct Tile {
  Content content;
  std::vector<std::uint32_t> hosts;  // of the skirt
};

/// Hills whose skirt's triangles hang from triangles all over the surface.
Tile hills() {
  Tile tile;
  tile.content.surface = mesh_of(shapes::height_field({.side = 32, .boundary = 24}));
  tile.content.skirt = skirt_of(tile.content.surface);
  tile.content.origin = {4096, -8192, 512};
  tile.content.materials = {{"shale", {141, 131, 119}, 0, 0.4, 0.6},
                            {"chalk", {207, 198, 176}, 0.4, 1, 0.8}};
  const auto surface = tile.content.surface.triangles.size();
  for (std::size_t t = 0; t < tile.content.skirt.triangles.size(); ++t) {
    tile.hosts.push_back(static_cast<std::uint32_t>(t * 7919 % surface));
  }
  return tile;
}

using Corner = std::tuple<std::array<std::int32_t, 3>, float, float, std::uint16_t>;
using Corners = std::vector<std::array<Corner, 3>>;

/// Triangles as their corners, sorted.
Corners corners(const surface::Mesh& mesh) {
  Corners all;
  for (const auto& t : mesh.triangles) {
    auto& triangle = all.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      triangle[c] = {mesh.points[t[c]], mesh.normals[t[c]].x, mesh.normals[t[c]].y,
                     mesh.materials[t[c]]};
    }
  }
  std::ranges::sort(all);
  return all;
}

TEST(Slabs, PartTheTrianglesAndAddNoVertex) {
  const auto [content, hosts] = hills();
  const auto parts = slabs(content, hosts, 300);
  ASSERT_EQ(parts.size(), (content.surface.triangles.size() + 299) / 300);
  Corners surface, skirt;
  for (const auto& part : parts) {
    EXPECT_LE(part.surface.triangles.size(), 300U);
    EXPECT_EQ(part.origin, content.origin);
    std::set<std::uint32_t> used;
    for (const auto& t : part.surface.triangles) used.insert(t.begin(), t.end());
    EXPECT_EQ(used.size(), part.surface.points.size()) << "no vertex without a triangle";
    const auto own = corners(part.surface), hung = corners(part.skirt);
    surface.insert(surface.end(), own.begin(), own.end());
    skirt.insert(skirt.end(), hung.begin(), hung.end());
  }
  std::ranges::sort(surface);
  std::ranges::sort(skirt);
  EXPECT_EQ(surface, corners(content.surface));
  EXPECT_EQ(skirt, corners(content.skirt));
}

TEST(Slabs, LieOneAboveTheOther) {
  const auto [content, hosts] = hills();
  const auto heights = [](const surface::Mesh& mesh) {
    std::vector<std::int64_t> all;  // three times the mean
    for (const auto& t : mesh.triangles) {
      all.push_back(std::int64_t{mesh.points[t[0]][2]} + mesh.points[t[1]][2] +
                    mesh.points[t[2]][2]);
    }
    return std::pair(std::ranges::min(all), std::ranges::max(all));
  };
  const auto parts = slabs(content, hosts, 500);
  ASSERT_GT(parts.size(), 2U);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    EXPECT_LE(heights(parts[i - 1].surface).second, heights(parts[i].surface).first);
  }
}

TEST(Slabs, TakeTheSkirtsOfTheirTriangles) {
  const Tile tile = hills();
  const Content& content = tile.content;
  auto hosts = tile.hosts;
  // All hang from the lowest triangle, then from the highest.
  const auto height = [&](std::uint32_t t) {
    std::int64_t sum = 0;
    for (const auto v : content.surface.triangles[t]) sum += content.surface.points[v][2];
    return sum;
  };
  std::vector<std::uint32_t> all(content.surface.triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  std::ranges::fill(hosts, std::ranges::min(all, {}, height));
  EXPECT_EQ(corners(slabs(content, hosts, 400).front().skirt), corners(content.skirt));
  std::ranges::fill(hosts, std::ranges::max(all, {}, height));
  EXPECT_EQ(corners(slabs(content, hosts, 400).back().skirt), corners(content.skirt));
}

TEST(Slabs, OfAContentWithinTheLimitAreItself) {
  const auto [content, hosts] = hills();
  const auto parts = slabs(content, hosts, content.surface.triangles.size());
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].surface.triangles, content.surface.triangles);
  EXPECT_EQ(parts[0].skirt.triangles, content.skirt.triangles);
}

TEST(Slabs, WrittenAndReadBackJoinToTheWholeTile) {
  const auto [content, hosts] = hills();
  std::vector<Decoded> read_back;
  for (auto part : slabs(content, hosts, 300)) {
    // As on the Earth, where every file chooses its own origin.
    part.origin[0] -= 100;
    for (auto* mesh : {&part.surface, &part.skirt}) {
      for (auto& p : mesh->points) p[0] += 100;
    }
    read_back.push_back(read(write(part, "plain"), content.step, "slab"));
  }
  read_back.front().origin[1] -= 7;
  for (auto* part : {&read_back.front().surface, &read_back.front().skirt}) {
    for (auto& p : part->points) p[1] += 7;
  }
  const auto all = join(std::move(read_back));
  const auto in_scene = [&](const auto& part, const std::array<std::int64_t, 3>& origin) {
    std::vector<std::array<std::array<std::int64_t, 3>, 3>> triangles;
    for (const auto& t : part.triangles) {
      auto& triangle = triangles.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t a = 0; a < 3; ++a) triangle[c][a] = origin[a] + part.points[t[c]][a];
      }
    }
    std::ranges::sort(triangles);
    return triangles;
  };
  EXPECT_EQ(in_scene(all.surface, all.origin), in_scene(content.surface, content.origin));
  EXPECT_EQ(in_scene(all.skirt, all.origin), in_scene(content.skirt, content.origin));
}

}  // namespace
}  // namespace hoodoo::glb
