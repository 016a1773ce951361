#include "engine/base/math.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace hoodoo {
namespace {

class Uniform {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
  }

 private:
  std::mt19937_64 engine_{7};
};

/// Of `found` against the C library's long double.
double relative_error(double found, long double right) {
  return static_cast<double>(std::abs((static_cast<long double>(found) - right) / right));
}

constexpr double promised = 1e-14;

TEST(BitMath, KeepsItsErrorBelowThePromise) {
  Uniform uniform;
  for (int i = 0; i < 100'000; ++i) {
    const double x = uniform(-1, 1) * std::pow(10.0, uniform(-8, 6));
    ASSERT_LT(relative_error(bit_sin(x), std::sin(static_cast<long double>(x))), promised) << x;
    ASSERT_LT(relative_error(bit_cos(x), std::cos(static_cast<long double>(x))), promised) << x;
    const double y = uniform(-700, 700);
    ASSERT_LT(relative_error(bit_exp(y), std::exp(static_cast<long double>(y))), promised) << y;
    const double z = i % 2 == 0 ? uniform(0.5, 1.5) : std::pow(10.0, uniform(-300, 300));
    ASSERT_LT(relative_error(bit_log(z), std::log(static_cast<long double>(z))), promised) << z;
    const double base = i % 2 == 0 ? uniform(0.9, 1.1) : std::pow(10.0, uniform(-3, 3));
    const double power = i % 2 == 0 ? uniform(-5000, 5000) : uniform(-90, 90);
    const auto right = std::pow(static_cast<long double>(base), static_cast<long double>(power));
    ASSERT_LT(relative_error(bit_pow(base, power), right), promised) << base << " " << power;
  }
}

TEST(BitMath, StaysExactNearTheZerosOfSineAndCosine) {
  for (int k = 1; k < 300'000; k += 7) {
    const double x = k * pi, c = (k + 0.5) * pi;
    ASSERT_LT(relative_error(bit_sin(x), std::sin(static_cast<long double>(x))), promised) << x;
    ASSERT_LT(relative_error(bit_cos(c), std::cos(static_cast<long double>(c))), promised) << c;
  }
}

TEST(BitMath, KeepsTheEdgeCasesOfPowersAndExponentials) {
  EXPECT_EQ(bit_pow(0, 2), 0);
  EXPECT_EQ(bit_pow(0, 0), 1);
  EXPECT_EQ(bit_pow(5, 0), 1);
  EXPECT_EQ(bit_pow(1, 1e300), 1);
  EXPECT_EQ(bit_pow(4, 0.5), 2);
  EXPECT_EQ(bit_exp(0), 1);
  EXPECT_EQ(bit_exp(-1000), 0);
  EXPECT_EQ(bit_exp(1000), std::numeric_limits<double>::infinity());
  EXPECT_EQ(bit_log(1), 0);
  EXPECT_EQ(bit_sin(0), 0);
  EXPECT_EQ(bit_cos(0), 1);
}

// The bits that every compiler and processor has to give.
TEST(BitMath, GivesTheBitsWrittenDown) {
  std::uint64_t all = 0;
  for (int i = 1; i <= 1000; ++i) {
    const double x = 0.37 * i;
    for (const double v : {bit_sin(x), bit_cos(x), bit_exp(x), bit_log(x), bit_pow(x, 1.3)}) {
      all = all * 1099511628211U ^ std::bit_cast<std::uint64_t>(v);
    }
  }
  EXPECT_EQ(all, 9730327237872800014U);
}

}  // namespace
}  // namespace hoodoo
