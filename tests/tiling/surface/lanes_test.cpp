#include "tiling/surface/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "engine/base/simd.hpp"
#include "tiling/surface/qef.hpp"
#include "tiling/surface/snap.hpp"
#include "tiling/surface/tables.hpp"

namespace hoodoo::surface {
namespace {

constexpr std::array simd_names{"ssse3", "sse4", "avx2", "best"};

/// Planes of the first edges of a cell, in any order.
std::vector<Plane3> random_sheet(std::mt19937& random, std::span<const unsigned> edges) {
  std::uniform_real_distribution<float> unit(0, 1), side(-1, 1);
  // From all alike over nearly alike to all ways, so that both ways to solve are taken.
  const float spread = random() % 3 == 0 ? 0 : random() % 2 == 0 ? 0.2F : 2;
  const Vec3 common{side(random), side(random), 1};
  std::vector<Plane3> planes;
  for (const unsigned edge : edges) {
    const auto turned = [&] { return static_cast<double>(spread * side(random)); };
    const std::size_t a = edge / 4;
    Vec3 point;
    point[static_cast<int>(next_axis(a))] = edge & 1;
    point[static_cast<int>(last_axis(a))] = edge >> 1 & 1;
    point[static_cast<int>(a)] = static_cast<double>(unit(random));
    // The normal is made single where it goes into the lanes.
    planes.push_back({point, normalized(common + Vec3{turned(), turned(), turned()})});
  }
  return planes;
}

TEST(SheetLanes, HaveTheBitsOfSheetsSolvedAloneOnEveryInstructionSet) {
  std::mt19937 random(11);
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    SheetLanes lanes;
    for (int trial = 0; trial < 2000; ++trial) {
      const std::size_t n = 1 + random() % SheetLanes::most;
      std::vector<std::vector<Plane3>> sheets(n);
      for (std::size_t i = 0; i < n; ++i) {
        std::array<unsigned, 12> edges;
        std::iota(edges.begin(), edges.end(), 0U);
        std::shuffle(edges.begin(), edges.end(), random);
        sheets[i] = random_sheet(random, std::span(edges).first(1 + random() % 12));
        lanes.count[i] = static_cast<double>(sheets[i].size());
        for (std::size_t k = 0; k < sheets[i].size(); ++k) {
          auto& normal = sheets[i][k].normal;
          const Vec3& p = sheets[i][k].point;
          const auto along = static_cast<int>(edges[k] / 4);
          lanes.plane[k][i] = {static_cast<float>(p[along]), static_cast<float>(normal.x),
                               static_cast<float>(normal.y), static_cast<float>(normal.z)};
          lanes.edge[k][i] = edge_code(edges[k]);
          normal = {lanes.plane[k][i][1], lanes.plane[k][i][2], lanes.plane[k][i][3]};
        }
      }
      const int units = 256 + static_cast<int>(random() % 256);
      solve(lanes, n, units);
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3 mean = mean_point(sheets[i]), best = mean + minimise(sheets[i], mean);
        for (std::size_t a = 0; a < 3; ++a) {
          const auto axis = static_cast<int>(a);
          ASSERT_EQ(lanes.mean[a][i], mean[axis]) << simd << ' ' << trial;
          ASSERT_EQ(lanes.point[i][a], snap(best[axis], units)) << simd << ' ' << trial;
        }
      }
    }
  }
  limit_simd("best", "");
}

/// The rule of QuadLanes, one quadrilateral at a time.
int diagonal_of(const std::array<Vec3, 4>& c, int axis, double sign, const Vec3& wanted) {
  std::array<double, 2> agreement{};
  for (std::size_t d = 0; d < 2; ++d) {
    const auto normal = [&](std::size_t b, std::size_t e) {
      return cross(c[b & 3] - c[d], c[e & 3] - c[d]) * sign;
    };
    const Vec3 first = normal(d + 1, d + 2), second = normal(d + 2, d + 3);
    if (!(first[axis] * sign > 0 && second[axis] * sign > 0)) return d == 0 ? 1 : 0;
    agreement[d] =
        std::min(dot(first, wanted) / length(first), dot(second, wanted) / length(second));
  }
  return agreement[0] >= agreement[1] ? 0 : 1;
}

TEST(QuadLanes, CutAsQuadrilateralsAloneOnEveryInstructionSet) {
  std::mt19937 random(12);
  std::uniform_int_distribution<int> step(1, 255);
  std::uniform_real_distribution<double> side(-1, 1);
  std::array<int, 2> begun{};
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    QuadLanes lanes;
    for (int trial = 0; trial < 600; ++trial) {
      const std::size_t n = 1 + random() % QuadLanes::most;
      const int axis = trial % 3;
      const std::size_t u = static_cast<std::size_t>(axis + 1) % 3, v = (u + 1) % 3;
      std::vector<Point> points(4 * n + 1);
      std::vector<volume::Crossing> crossings(n);
      std::vector<std::array<Vec3, 4>> corners(n);
      std::vector<Vec3> wanted(n);
      for (std::size_t i = 0; i < n; ++i) {
        lanes.sign[i] = random() % 2 == 0 ? 1.0F : -1.0F;
        const Vec3 w = normalized({side(random), side(random), side(random)});
        auto& single = crossings[i].normal;
        single = {static_cast<float>(w.x), static_cast<float>(w.y), static_cast<float>(w.z)};
        wanted[i] = {single.x, single.y, single.z};
        lanes.crossing[i] = &crossings[i];
        for (std::size_t q = 0; q < 4; ++q) {
          const std::size_t vertex = q * n + i;
          lanes.corner[i][q] = static_cast<std::uint32_t>(vertex);
          auto& p = points[vertex];
          p[static_cast<std::size_t>(axis)] = step(random) - 128;
          p[u] = q == 1 || q == 2 ? step(random) : -step(random);
          p[v] = q >= 2 ? step(random) : -step(random);
          for (std::size_t a = 0; a < 3; ++a) corners[i][q][static_cast<int>(a)] = p[a];
        }
      }
      cut(lanes, n, axis, points.data());
      for (std::size_t i = 0; i < n; ++i) {
        const auto sign = static_cast<double>(lanes.sign[i]);
        ASSERT_EQ(lanes.diagonal[i], diagonal_of(corners[i], axis, sign, wanted[i])) << simd;
        ++begun[static_cast<std::size_t>(lanes.diagonal[i])];
      }
    }
  }
  limit_simd("best", "");
  EXPECT_GT(begun[0], 1000);
  EXPECT_GT(begun[1], 1000);
}

}  // namespace
}  // namespace hoodoo::surface
