#include "tiling/lod/half_edges.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tiling/lod/faces.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::lod {
namespace {

Topology of(const std::vector<Triangle>& triangles, std::size_t vertices) {
  return topology(triangles, HalfEdges(triangles, vertices));
}

TEST(Topology, OfATetrahedronIsASphere) {
  const auto t = of({{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}, 4);
  EXPECT_TRUE(t.sound());
  EXPECT_TRUE(t.open.empty());
  EXPECT_TRUE(t.split.empty());
  EXPECT_EQ(t.euler, 2);
}

TEST(Topology, ListsOpenEdgesByVertex) {
  const auto t = of({{0, 1, 2}, {2, 1, 3}}, 4);
  ASSERT_EQ(t.open.size(), 4U);
  EXPECT_EQ(t.open[0], (Topology::Open{0, 1, 0}));
  EXPECT_EQ(t.open[3], (Topology::Open{3, 2, 1}));
  EXPECT_EQ(t.euler, 1);
}

TEST(Topology, SeesTwoFansAtOneVertex) {
  const auto open = of({{0, 1, 2}, {0, 3, 4}}, 5);
  ASSERT_EQ(open.split.size(), 1U);
  EXPECT_EQ(open.split[0], (Topology::Fans{0, 2}));
  // Two tetrahedra that share a vertex.
  const auto closed = of(
      {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}, {0, 4, 5}, {0, 6, 4}, {4, 6, 5}, {5, 6, 0}}, 7);
  ASSERT_EQ(closed.split.size(), 1U);
  EXPECT_EQ(closed.split[0], (Topology::Fans{0, 2}));
}

TEST(Topology, SeesDoubledTurnedAndDegenerateTriangles) {
  EXPECT_FALSE(of({{0, 1, 2}, {0, 1, 2}}, 3).sound());
  EXPECT_FALSE(of({{0, 1, 2}, {0, 2, 1}}, 3).sound());
  EXPECT_FALSE(of({{0, 1, 2}, {0, 1, 3}}, 4).sound());
  EXPECT_FALSE(of({{0, 0, 2}}, 3).sound());
}

TEST(Fins, AreRemovedAndNothingElse) {
  Faces faces{{{0, 1, 2}, {2, 1, 3}, {1, 2, 4}, {2, 1, 4}}, {0, 0, 1, 1}};
  drop_fins(faces, 5);
  EXPECT_EQ(faces.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(faces.materials, (std::vector<std::uint16_t>{0, 0}));
}

TEST(Chords, AreTurnedAwayFromTheBorderOneVertexAtATime) {
  // 0 1 2 3 on the western plane, 4 off it: (0, 2) and (0, 3) run along the plane.
  const std::vector<std::uint8_t> planes{surface::west, surface::west, surface::west, surface::west,
                                         0};
  Faces faces{{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}, {5, 6, 7}};
  turn_chords(faces, planes);
  EXPECT_TRUE(chords(HalfEdges(faces.triangles, 5), planes).empty());
  const auto t = of(faces.triangles, 5);
  EXPECT_TRUE(t.sound());
  EXPECT_EQ(t.open.size(), 5U);
  for (const auto& [edge, material] : std::map<std::pair<std::uint32_t, std::uint32_t>, int>{
           {{0, 1}, 5}, {{1, 2}, 5}, {{2, 3}, 6}}) {
    const HalfEdges edges(faces.triangles, 5);
    EXPECT_EQ(faces.materials[edges.find(edge.first, edge.second)->triangle], material);
  }
}

}  // namespace
}  // namespace hoodoo::lod
