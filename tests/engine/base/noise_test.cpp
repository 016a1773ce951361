#include "engine/base/noise.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "engine/base/random.hpp"

namespace hoodoo {
namespace {

struct Cloud {
  std::vector<float> x, y, z;
  Cloud(std::size_t n, float far) {
    std::mt19937 engine(3);
    const auto any = [&] { return far * (static_cast<float>(engine() >> 8) / 8388608.0F - 1); };
    for (std::size_t i = 0; i < n; ++i) {
      x.push_back(any());
      y.push_back(any());
      z.push_back(any());
    }
  }
  std::size_t size() const { return x.size(); }
};

std::vector<float> values(const Turbulence& t, const Vec3& origin, const Cloud& c) {
  std::vector<float> out(c.size());
  turbulence(t, origin, c.x, c.y, c.z, out);
  return out;
}

struct Slopes {
  std::vector<float> f, x, y, z;
};

Slopes slopes(const Turbulence& t, const Vec3& origin, const Cloud& c) {
  const std::size_t n = c.size();
  Slopes s{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n),
           std::vector<float>(n)};
  turbulence_gradient(t, origin, c.x, c.y, c.z, s.f, s.x, s.y, s.z);
  return s;
}

/// The same noise in the plainest words: one point, one octave after another, no Highway.
float plain_turbulence(const Turbulence& t, const Vec3& origin, float x, float y, float z) {
  const double norm = 2 - std::ldexp(1.0, 1 - t.octaves);
  float sum = 0;
  for (int o = 0; o < t.octaves; ++o) {
    const double f = std::ldexp(1 / t.wavelength, o);
    const auto offset = [&](int a) { return 256 * unit_real(random_bits(t.seed, o, a)); };
    const Vec3 p = origin * f + Vec3{offset(0), offset(1), offset(2)};
    const double skew = (p.x + p.y + p.z) / 3;
    const std::array<double, 3> cell{std::floor(p.x + skew), std::floor(p.y + skew),
                                     std::floor(p.z + skew)};
    const double back = (cell[0] + cell[1] + cell[2]) / 6;
    const auto ff = static_cast<float>(f);
    const std::array<float, 3> q{x * ff + static_cast<float>(p.x - (cell[0] - back)),
                                 y * ff + static_cast<float>(p.y - (cell[1] - back)),
                                 z * ff + static_cast<float>(p.z - (cell[2] - back))};
    const float s = ((q[0] + q[1]) + q[2]) * (1.0F / 3);
    std::array<float, 3> corner{}, d{};
    for (std::size_t a = 0; a < 3; ++a) corner[a] = std::floor(q[a] + s);
    const float b = ((corner[0] + corner[1]) + corner[2]) * (1.0F / 6);
    for (std::size_t a = 0; a < 3; ++a) d[a] = q[a] - (corner[a] - b);
    // Steps to the four corners, largest coordinate first; among equals x before y before z.
    std::array<std::array<int, 3>, 4> steps{};
    const bool xy = d[0] >= d[1], xz = d[0] >= d[2], yz = d[1] >= d[2];
    steps[1] = {xy && xz, !xy && yz, !xz && !yz};
    steps[2] = {xy || xz, !xy || yz, !(xz && yz)};
    steps[3] = {1, 1, 1};
    float n = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      std::uint32_t word = static_cast<std::uint32_t>(random_bits(t.seed, o, 3));
      const std::array<std::uint32_t, 3> prime{0x8da6b343U, 0xd8163841U, 0xcb1ab31fU};
      std::array<std::uint32_t, 3> part{};
      std::array<float, 3> e{};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto index = static_cast<std::uint32_t>(static_cast<std::int64_t>(corner[a])) +
                           static_cast<std::uint32_t>(static_cast<std::int64_t>(cell[a])) +
                           static_cast<std::uint32_t>(steps[k][a]);
        part[a] = index * prime[a];
        const float step = static_cast<float>(steps[k][a]);
        const float sixth = 1.0F / 6;
        e[a] = k == 0   ? d[a]
               : k == 3 ? d[a] - 0.5F
                        : (d[a] - step) + (k == 1 ? sixth : sixth + sixth);
      }
      std::uint32_t h = ((part[0] + word) ^ part[1]) ^ part[2];
      h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
      h = (h ^ (h >> 12)) * 0x297a2d39U;
      h = (h ^ (h >> 15)) & 15;
      const float r2 = (e[0] * e[0] + e[1] * e[1]) + e[2] * e[2];
      const float w = 0.5F - r2 > 0 ? 0.5F - r2 : 0;
      const float u = h < 8 ? e[0] : e[1], v = h < 4 ? e[1] : (h & 13) == 12 ? e[0] : e[2];
      n += (w * w) * (w * w) * (((h & 1) != 0 ? -u : u) + ((h & 2) != 0 ? -v : v));
    }
    const float unit = n * (0.5F * 76.8826F) + 0.5F;
    sum += std::min(std::max(unit, 0.0F), 1.0F) * static_cast<float>(std::ldexp(1 / norm, -o));
  }
  return std::min(sum, 1.0F);
}

constexpr Vec3 far_away{512'000, 5'200'000, 1'200};

TEST(Turbulence, GivesTheBitsOfThePlainLoop) {
  const Cloud cloud(1001, 40);
  const Turbulence t{7.3, 4, 11};
  const auto out = values(t, far_away, cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float plain = plain_turbulence(t, far_away, cloud.x[i], cloud.y[i], cloud.z[i]);
    ASSERT_EQ(std::bit_cast<std::uint32_t>(out[i]), std::bit_cast<std::uint32_t>(plain)) << i;
  }
}

TEST(Turbulence, GivesTheSameBitsOnEveryInstructionSet) {
  const Cloud cloud(333, 100);
  const Turbulence t{5, 5, 2};
  const Slopes best = slopes(t, far_away, cloud);
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t target = all & -all; target > 0; target = target << 1) {
    if ((all & target) == 0) continue;
    hwy::SetSupportedTargetsForTest(target);
    const Slopes s = slopes(t, far_away, cloud);
    EXPECT_TRUE(s.f == best.f && s.x == best.x && s.y == best.y && s.z == best.z)
        << hwy::TargetName(target);
    EXPECT_EQ(values(t, far_away, cloud), best.f) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Turbulence, FillsTheUnitIntervalAboutItsMiddle) {
  for (const int octaves : {1, 3, 12}) {
    const Cloud cloud(20'000, 1000);
    double sum = 0;
    float low = 1, high = 0;
    for (const float v : values({10, octaves, 5}, {}, cloud)) {
      sum += static_cast<double>(v);
      low = std::min(low, v);
      high = std::max(high, v);
    }
    EXPECT_GE(low, 0.0F);
    EXPECT_LE(high, 1.0F);
    EXPECT_NEAR(sum / 20'000, 0.5, 0.01);
    EXPECT_LT(low, 0.25F);
    EXPECT_GT(high, 0.75F);
  }
}

TEST(Turbulence, IsTheSameNoiseWhereverTheOriginLies) {
  const Cloud cloud(200, 10);
  const Turbulence t{9, 3, 4};
  Cloud moved = cloud;
  for (float& v : moved.x) v += 16;
  for (float& v : moved.z) v -= 32;
  const auto a = values(t, far_away + Vec3{16, 0, -32}, cloud), b = values(t, far_away, moved);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-5F);
}

TEST(Turbulence, ChangesWithItsSeedAndHasNoCommonCentre) {
  const float zero = 0;
  std::vector<float> at_origin;
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    float v = 0;
    turbulence({10, 3, seed}, {}, {&zero, 1}, {&zero, 1}, {&zero, 1}, {&v, 1});
    at_origin.push_back(v);
  }
  std::sort(at_origin.begin(), at_origin.end());
  EXPECT_EQ(std::unique(at_origin.begin(), at_origin.end()), at_origin.end());
  EXPECT_LT(at_origin.front(), 0.45F);
  EXPECT_GT(at_origin.back(), 0.55F);
}

TEST(Turbulence, HasTheGradientOfItsValuesAndKeepsItsSlopeBound) {
  const Cloud cloud(4000, 50);
  const Turbulence t{10, 2, 9};
  const Slopes s = slopes(t, {3, 4, 5}, cloud);
  EXPECT_EQ(values(t, {3, 4, 5}, cloud), s.f);
  constexpr float h = 1.0F / 64;
  for (int axis = 0; axis < 3; ++axis) {
    Cloud ahead = cloud, behind = cloud;
    for (float& v : axis == 0 ? ahead.x : axis == 1 ? ahead.y : ahead.z) v += h;
    for (float& v : axis == 0 ? behind.x : axis == 1 ? behind.y : behind.z) v -= h;
    const auto up = values(t, {3, 4, 5}, ahead), down = values(t, {3, 4, 5}, behind);
    const auto& g = axis == 0 ? s.x : axis == 1 ? s.y : s.z;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ASSERT_NEAR(g[i], (up[i] - down[i]) / (2 * h), 2e-4F);
    }
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_LE(std::hypot(s.x[i], s.y[i], s.z[i]), turbulence_slope(t));
  }
}

TEST(Turbulence, StaysFiniteBeyondAnySensibleBlock) {
  const float far = 1e12F;
  float v = -1;
  turbulence({0.001, 12, 1}, far_away, {&far, 1}, {&far, 1}, {&far, 1}, {&v, 1});
  EXPECT_TRUE(v >= 0 && v <= 1);
}

}  // namespace
}  // namespace hoodoo
