#include "tiling/tileset/farthest.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/random.hpp"
#include "tiling/lod/buckets.hpp"
#include "tiling/lod/deviation.hpp"

namespace hoodoo::tileset {
namespace {

/// A sheet of 2 n^2 triangles over [0, 1]^2, with random heights up to `rough`.
Patch sheet(std::uint32_t n, double rough, std::uint64_t seed) {
  Patch patch;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      patch.points.push_back({static_cast<double>(i) / n, static_cast<double>(j) / n,
                              rough * unit_real(random_bits(seed, i, j))});
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const auto a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      patch.triangles.push_back({a, b, d});
      patch.triangles.push_back({a, d, c});
    }
  }
  return patch;
}

/// By dense samples: never more than the distance itself.
double sampled(const Patch& from, const Patch& to, double spacing) {
  const lod::Buckets buckets(to.points, to.triangles, 0.2);
  lod::Farthest farthest(1e30, 0);
  for (const auto& [ia, ib, ic] : from.triangles) {
    const Vec3 &a = from.points[ia], &b = from.points[ib], &c = from.points[ic];
    for (const auto& p : {a, b, c}) farthest.look(p, buckets);
    lod::for_each_sample(a, b, c, spacing, [&](const Vec3& p) { farthest.look(p, buckets); });
  }
  return farthest.distance();
}

TEST(Farthest, IsNeverLessThanTheDistanceAndHardlyMore) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const auto n = static_cast<std::uint32_t>(seed);
    const Patch from = sheet(2 + n % 5, 0.4, seed), to = sheet(3 + n % 7, 0.4, seed + 100);
    const double more = 0.02, found = farthest(from, to, 0.2, more);
    EXPECT_GE(found, sampled(from, to, 0.01)) << "seed " << seed;
    // Between samples a distance goes on by at most 0.01 / sqrt(2).
    EXPECT_LE(found, sampled(from, to, 0.01) + 0.0075 + more) << "seed " << seed;
  }
}

TEST(Farthest, SeesWhatLiesBetweenTheCorners) {
  // Two squares whose corners agree, creased along different diagonals.
  Patch ridge, valley;
  ridge.points = valley.points = {{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}};
  ridge.triangles = {{0, 1, 2}, {0, 2, 3}};
  valley.triangles = {{0, 1, 3}, {1, 2, 3}};
  // The middle of a crease is nearest to the edges between the others' corners and the middle.
  EXPECT_GT(farthest(ridge, valley, 1, 1e-3), 0.5);
  EXPECT_NEAR(farthest(ridge, valley, 1, 1e-3), sampled(ridge, valley, 1e-3), 2e-3);
}

TEST(Farthest, OfASheetFromItselfIsWhatItMayBeTooLarge) {
  const Patch patch = sheet(8, 0.3, 5);
  EXPECT_LE(farthest(patch, patch, 0.2, 0.01), 0.01);
}

}  // namespace
}  // namespace hoodoo::tileset
