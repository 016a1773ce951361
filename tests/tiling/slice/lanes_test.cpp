#include "tiling/slice/lanes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "engine/base/simd.hpp"

namespace hoodoo::slice {
namespace {

constexpr std::array simd_names{"ssse3", "sse4", "avx2", "best"};
using Numbers = std::array<std::vector<double>, 3>;

Along along(Numbers& of) { return {of[0], of[1], of[2]}; }

/// One more than is to be written, which must stay.
Numbers room(std::size_t n) {
  Numbers of;
  for (auto& all : of) all.assign(n + 1, 9);
  return of;
}

TEST(ToMetres, HasTheBitsOfEachPointAloneOnEveryInstructionSet) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int32_t> offset(-100'000, 100'000);
  const std::array<double, 3> origin{1e9, -7e8, 123};
  const double step = 300.0 / 65536;
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    for (std::size_t n = 0; n < 40; ++n) {
      std::vector<std::array<std::int32_t, 3>> points(n);
      for (auto& p : points) p = {offset(random), offset(random), offset(random)};
      Numbers out = room(n);
      to_metres(points, origin, step, along(out));
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t i = 0; i < n; ++i) {
          ASSERT_EQ(out[a][i], (origin[a] + points[i][a]) * step) << simd;
        }
        ASSERT_EQ(out[a][n], 9) << simd;
      }
    }
  }
  limit_simd("best", "");
}

TEST(NewtonSteps, HaveTheBitsOfEachPointAloneOnEveryInstructionSet) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-3, 3);
  for (const char* simd : simd_names) {
    limit_simd(simd, "");
    for (std::size_t n = 0; n < 40; ++n) {
      std::vector<double> above(n);
      Numbers gradient, out = room(n);
      for (double& v : above) v = number(random);
      for (auto& all : gradient) all.assign(n, 0);
      for (std::size_t i = 0; i < n; ++i) {
        // Some have no gradient.
        for (auto& all : gradient) all[i] = i % 5 == 4 ? 0 : number(random);
      }
      newton_steps(above, {gradient[0], gradient[1], gradient[2]}, along(out));
      for (std::size_t i = 0; i < n; ++i) {
        const double x = gradient[0][i], y = gradient[1][i], z = gradient[2][i];
        const double squared = x * x + y * y + z * z;
        for (std::size_t a = 0; a < 3; ++a) {
          const double wanted = squared > 0 ? gradient[a][i] * (-above[i] / squared) : 0;
          ASSERT_EQ(out[a][i], wanted) << simd;
        }
      }
      for (const auto& all : out) ASSERT_EQ(all[n], 9) << simd;
    }
  }
  limit_simd("best", "");
}

}  // namespace
}  // namespace hoodoo::slice
