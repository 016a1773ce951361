#include "tiling/export/shells.hpp"

#include <gtest/gtest.h>

#include <array>

namespace hoodoo::exporting {
namespace {

using tileset::Patch;

/// A closed box of half side `half` around `center`; `hollow`: turned to the air inside.
void add_box(Patch& patch, const Vec3& center, double half, bool hollow = false) {
  const auto first = static_cast<std::uint32_t>(patch.points.size());
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner{(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half,
                      (i & 4) != 0 ? half : -half};
    patch.points.push_back(center + corner);
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> faces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : faces) {
    for (const auto& [p, q] : {std::pair(b, c), std::pair(c, d)}) {
      patch.triangles.push_back(hollow ? lod::Triangle{first + a, first + q, first + p}
                                       : lod::Triangle{first + a, first + p, first + q});
    }
  }
}

TEST(SortShells, TellsRockFromCavities) {
  Patch patch;
  add_box(patch, {0, 0, 0}, 5);
  add_box(patch, {0, 0, 0}, 3, true);
  const auto shells = sort_shells(patch);
  EXPECT_EQ(shells.solids.triangles.size(), 12U);
  EXPECT_EQ(shells.solids.points.front().x, -5);
  EXPECT_EQ(shells.cavities.triangles.size(), 12U);
  EXPECT_EQ(shells.cavities.points.front().x, -3);
  EXPECT_TRUE(shells.inner.triangles.empty());
}

TEST(SortShells, TurnsCavitiesInsideOut) {
  Patch patch;
  add_box(patch, {0, 0, 0}, 3, true);
  EXPECT_TRUE(sort_shells(sort_shells(patch).cavities).cavities.triangles.empty());
}

TEST(SortShells, FindsARockInACavity) {
  Patch patch;
  add_box(patch, {0, 0, 0}, 5);
  add_box(patch, {0, 0, 0}, 3, true);
  add_box(patch, {1, 1, 1}, 1);
  add_box(patch, {20, 0, 0}, 1);
  const auto shells = sort_shells(patch);
  EXPECT_EQ(shells.solids.triangles.size(), 36U);
  EXPECT_EQ(shells.inner.triangles.size(), 12U);
  EXPECT_EQ(shells.inner.points.front().x, 0);
}

TEST(SortShells, TakesAnOpenPartForGround) {
  Patch patch;
  add_box(patch, {0, 0, 0}, 3, true);
  patch.triangles.pop_back();
  const auto shells = sort_shells(patch);
  EXPECT_TRUE(shells.cavities.triangles.empty());
  EXPECT_EQ(shells.solids.triangles.size(), 11U);
}

}  // namespace
}  // namespace hoodoo::exporting
