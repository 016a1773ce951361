#include "tiling/volume/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>

#include "engine/base/simd.hpp"
#include "engine/base/vector.hpp"
#include "tiling/volume/root.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {
namespace {

constexpr std::array simd_names{"ssse3", "sse4", "avx2", "best"};

TEST(CountBits, CountsThoseOfSixteen) {
  for (unsigned bits = 0; bits < 65536; ++bits) {
    ASSERT_EQ(count_bits(bits), static_cast<std::size_t>(std::popcount(bits)));
  }
}

TEST(Signs, AreThoseOfEachPointOnEveryInstructionSet) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> elevation(90, 130);
  std::uniform_real_distribution<float> value(0.4F, 0.6F);
  std::array<double, 289> heights;
  std::array<float, 4096> values;
  std::array<std::uint16_t, 256> rows;
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    for (double& h : heights) h = elevation(random);
    heights[18] = 103;  // on a point: air
    find_signs(heights, 100, 1.5, rows);
    for (std::size_t n = 0; n < 4096; ++n) {
      const std::size_t x = n & 15, y = n >> 4 & 15, z = n >> 8;
      ASSERT_EQ((rows[16 * z + y] >> x & 1) != 0,
                heights[17 * y + x] > 100 + static_cast<double>(z) * 1.5)
          << simd << ' ' << n;
    }
    for (float& v : values) v = value(random);
    values[5] = 0.5F;  // air
    find_signs(values, rows);
    for (std::size_t n = 0; n < 4096; ++n) {
      const std::size_t z = n & 15, y = n >> 4 & 15, x = n >> 8;
      ASSERT_EQ((rows[16 * z + y] >> x & 1) != 0, values[n] > 0.5F) << simd << ' ' << n;
    }
  }
  limit_simd("best", "");
}

TEST(PointAgainst, HasTheBitsOfNormalizedOnEveryInstructionSet) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> part(-3, 3);
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    for (std::size_t n = 0; n < 40; ++n) {
      std::array<std::vector<double>, 3> v;
      std::array<std::vector<float>, 3> out;
      for (auto& along : v) {
        for (std::size_t i = 0; i < n; ++i) along.push_back(i % 7 == 6 ? 0 : part(random));
      }
      for (auto& along : out) along.assign(n, 9);
      point_against(v[0], v[1], v[2], {out[0], out[1], out[2]});
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3 unit = normalized({-v[0][i], -v[1][i], -v[2][i]}, {0, 0, 0});
        ASSERT_EQ(out[0][i], static_cast<float>(unit.x)) << simd;
        ASSERT_EQ(out[1][i], static_cast<float>(unit.y)) << simd;
        ASSERT_EQ(out[2][i], static_cast<float>(unit.z)) << simd;
      }
    }
  }
  limit_simd("best", "");
}

TEST(RootLanes, FindTheBitsThatEachEdgeAloneFinds) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> root(0.001, 0.999), bend(0, 30);
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    for (std::size_t n = 1; n < 60; n += 7) {
      std::vector<double> roots, bends, low, high, found(2 * n, -1);
      std::vector<std::uint32_t> edges;
      const auto value = [&](std::size_t i, double t) {
        const double u = t - roots[i];
        return (i % 2 == 0 ? 1 : -1) * (u + bends[i] * u * u * u);
      };
      for (std::size_t i = 0; i < n; ++i) {
        roots.push_back(root(random));
        bends.push_back(bend(random));
        low.push_back(value(i, 0));
        high.push_back(value(i, 1));
        edges.push_back(static_cast<std::uint32_t>(2 * i + 1));
      }
      RootLanes lanes;
      lanes.start(edges, low, high);
      int steps = 0;
      std::vector<double> values;
      while (!lanes.edges().empty()) {
        ASSERT_LT(++steps, 20);
        const auto places = lanes.places();
        values.resize(places.size() + 8);
        for (std::size_t k = 0; k < places.size(); ++k) {
          values[k] = value((lanes.edges()[k] - 1) / 2, places[k]);
        }
        lanes.put(std::span(values).first(places.size()), found);
      }
      for (std::size_t i = 0; i < n; ++i) {
        RootFinder alone(low[i], high[i]);
        while (!alone.done()) {
          const double t = alone.next();
          alone.put(t, value(i, t));
        }
        ASSERT_EQ(found[2 * i + 1], alone.root()) << simd;
        ASSERT_EQ(found[2 * i], -1);
      }
    }
  }
  limit_simd("best", "");
}

}  // namespace
}  // namespace hoodoo::volume
