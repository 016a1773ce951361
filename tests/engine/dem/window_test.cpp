#include "engine/dem/window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "engine/base/simd.hpp"

namespace hoodoo::dem {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Window window_of(int width, int height, const auto& sample, double x0 = 0, double y0 = 0,
                 double dx = 1, double dy = 1) {
  std::vector<float> samples;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) samples.push_back(static_cast<float>(sample(i, j)));
  }
  return Window(x0, y0, dx, dy, 0, 0, width, height, samples);
}

Box area(double x0, double y0, double x1, double y1) { return {{x0, y0, 0}, {x1, y1, 0}}; }

TEST(Window, PassesThroughItsSamplesAtPixelCentres) {
  const auto w = window_of(
      9, 9, [](int i, int j) { return i * i - 3 * j + (i * j) % 5; }, 100, 200, 2, 3);
  for (int j = 2; j < 7; ++j) {
    for (int i = 2; i < 7; ++i) {
      EXPECT_EQ(w.height(100 + 2 * (i + 0.5), 200 + 3 * (j + 0.5)), i * i - 3 * j + (i * j) % 5);
    }
  }
}

TEST(Window, GivesAGridTheBitsOfItsPoints) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> sample(-500, 4000), part(0, 1);
  const auto w = window_of(
      40, 30, [&](int, int) { return part(random) < 0.1F ? nan : sample(random); }, -20, 5, 2, 3);
  std::uniform_real_distribution<double> anywhere(-60, 120), step(0, 9);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> x, y;
    const double across = step(random), along = trial % 4 == 0 ? 40 * step(random) : step(random);
    for (int i = 0; i < 1 + trial % 17; ++i) x.push_back(anywhere(random) + i * across);
    const double from = anywhere(random);
    for (int j = 0; j < 1 + trial % 35; ++j) y.push_back(from + j * along);
    const std::size_t n = x.size() * y.size();
    std::vector<double> h(n), hx(n), hy(n), alone(n);
    std::vector<std::uint8_t> valid(n);
    limit_simd(std::array{"ssse3", "sse4", "avx2", "best"}[static_cast<std::size_t>(trial) % 4],
               "");
    w.grid(x, y, {h, hx, hy});
    w.grid(x, y, {alone, {}, {}});
    w.valid(x, y, valid);
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (std::size_t j = 0; j < y.size(); ++j) {
        const std::size_t k = x.size() * j + i;
        const Height one = w.at(x[i], y[j]);
        ASSERT_EQ(h[k], one.h) << x[i] << ' ' << y[j];
        ASSERT_EQ(hx[k], one.hx) << x[i] << ' ' << y[j];
        ASSERT_EQ(hy[k], one.hy) << x[i] << ' ' << y[j];
        ASSERT_EQ(alone[k], one.h) << x[i] << ' ' << y[j];
        ASSERT_EQ(valid[k] != 0, w.valid(x[i], y[j])) << x[i] << ' ' << y[j];
      }
    }
  }
  limit_simd("best", "");
  std::vector<double> none(6, 7);
  Window().grid(std::vector<double>{1, 2}, std::vector<double>{1, 2, 3}, {none, {}, {}});
  EXPECT_EQ(none, std::vector<double>(6, 0));
}

TEST(Window, GivesManyPointsTheBitsOfEachOnEveryInstructionSet) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> sample(-500, 4000), part(0, 1);
  std::uniform_real_distribution<double> anywhere(-60, 120);
  const auto w = window_of(
      40, 30, [&](int, int) { return part(random) < 0.1F ? nan : sample(random); }, -20, 5, 2, 3);
  for (const char* simd : {"ssse3", "sse4", "avx2", "best"}) {
    limit_simd(simd, "");
    for (std::size_t n = 0; n < 70; ++n) {
      std::vector<double> x(n), y(n), h(n), hx(n), hy(n), alone(n);
      for (std::size_t i = 0; i < n; ++i) {
        // Most inside the window, some beyond it, some on samples.
        x[i] = i % 3 == 0 ? anywhere(random) : 0.2 * anywhere(random) + 10;
        y[i] = i % 3 == 0 ? anywhere(random) : 0.2 * anywhere(random) + 30;
        if (i % 5 == 0) x[i] = std::floor(x[i]), y[i] = 3 * std::floor(y[i] / 3) + 0.5;
        if (i % 31 == 30) x[i] = 1e300;
      }
      w.at(x, y, {h, hx, hy});
      w.heights_at(x, y, alone);
      for (std::size_t i = 0; i < n; ++i) {
        const Height one = w.at(x[i], y[i]);
        ASSERT_EQ(h[i], one.h) << simd << ' ' << x[i] << ' ' << y[i];
        ASSERT_EQ(hx[i], one.hx) << simd << ' ' << x[i] << ' ' << y[i];
        ASSERT_EQ(hy[i], one.hy) << simd << ' ' << x[i] << ' ' << y[i];
        ASSERT_EQ(alone[i], w.height(x[i], y[i])) << simd;
      }
    }
  }
  limit_simd("best", "");
  std::vector<double> at{1, 2}, h{7, 7}, hx{7, 7}, hy{7, 7};
  Window().at(at, at, {h, hx, hy});
  EXPECT_EQ(h, std::vector<double>(2, 0));
}

TEST(Window, ReproducesQuadraticsWithTheirGradients) {
  const auto f = [](double x, double y) {
    return 3 + 2 * x - y + 0.5 * x * x - 0.25 * x * y + y * y;
  };
  const auto w = window_of(20, 20, [&](int i, int j) { return f(i + 0.5, j + 0.5); });
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(3, 17);
  for (int k = 0; k < 1000; ++k) {
    const double x = at(random), y = at(random);
    const auto h = w.at(x, y);
    EXPECT_NEAR(h.h, f(x, y), 1e-9);
    EXPECT_NEAR(h.hx, 2 + x - 0.25 * y, 1e-9);
    EXPECT_NEAR(h.hy, -1 - 0.25 * x + 2 * y, 1e-9);
  }
}

Window rough(int size, unsigned seed, double dx, double dy, double holes = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(-100, 900), part(0, 1);
  return window_of(
      size, size,
      [&](int, int) {
        const double h = height(random);
        return part(random) < holes ? static_cast<double>(nan) : h;
      },
      -7, 11, dx, dy);
}

TEST(Window, GivesTheGradientThatFiniteDifferencesGive) {
  const auto w = rough(30, 2, 1.5, 2.5);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-20, 80);
  constexpr double e = 1e-5;
  for (int k = 0; k < 1000; ++k) {
    const double x = at(random), y = at(random);
    const auto h = w.at(x, y);
    EXPECT_EQ(h.h, w.height(x, y));
    EXPECT_NEAR(h.hx, (w.height(x + e, y) - w.height(x - e, y)) / (2 * e), 0.05);
    EXPECT_NEAR(h.hy, (w.height(x, y + e) - w.height(x, y - e)) / (2 * e), 0.05);
  }
}

TEST(Window, BoundsHoldAndAreNotFarOff) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> at(-20, 60), size(0, 12);
  double reached = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto w = rough(24, seed, 1.5, 2.5, 0.2);
    for (int k = 0; k < 20; ++k) {
      const double x = at(random), y = at(random);
      const auto box = area(x, y, x + size(random), y + size(random));
      const auto bounds = w.bounds(box);
      const double slope = w.slope(box);
      std::uniform_real_distribution<double> px(box.min.x, box.max.x), py(box.min.y, box.max.y);
      double low = 1e9, high = -1e9;
      for (int n = 0; n < 400; ++n) {
        const auto h = w.at(px(random), py(random));
        ASSERT_TRUE(bounds.contains(h.h)) << seed;
        ASSERT_LE(std::sqrt(h.hx * h.hx + h.hy * h.hy), slope) << seed;
        low = std::min(low, h.h);
        high = std::max(high, h.h);
      }
      if (bounds.width() > 0) reached = std::max(reached, (high - low) / bounds.width());
    }
  }
  EXPECT_GT(reached, 0.5);
}

TEST(Window, ContinuesTheNearestValidSampleBesideNoData) {
  const auto w = window_of(20, 9, [](int i, int j) { return i < 6 ? 10.0 * j : nan; });
  EXPECT_TRUE(w.valid(5.999, 4.5));
  EXPECT_FALSE(w.valid(6.0, 4.5));
  EXPECT_EQ(w.height(5.5, 4.5), 40);
  EXPECT_EQ(w.height(9.5, 4.5), 40);  // four pixels beyond the last valid one
  EXPECT_EQ(w.height(14.5, 4.5), 0);  // nothing near
  EXPECT_EQ(w.at(7.5, 4.5).hx, 0);
}

TEST(Window, IsTheSameBitsWhicheverWindowHoldsThePoint) {
  constexpr int size = 60;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> height(0, 1000), part(0, 1);
  std::vector<float> all(size * size);
  for (auto& v : all) v = part(random) < 0.3f ? nan : height(random);
  const double x0 = 1234.1, y0 = -77.7, dx = 0.3, dy = 0.7;
  const Window whole(x0, y0, dx, dy, 0, 0, size, size, all);
  for (int k = 0; k < 200; ++k) {
    const int i = static_cast<int>(random() % 30), j = static_cast<int>(random() % 30), n = 30;
    std::vector<float> part_of;
    for (int l = 0; l < n; ++l) {
      part_of.insert(part_of.end(), all.begin() + (j + l) * size + i,
                     all.begin() + (j + l) * size + i + n);
    }
    const Window w(x0, y0, dx, dy, i, j, n, n, part_of);
    constexpr int margin = 7;
    std::uniform_real_distribution<double> u(i + margin, i + n - margin),
        v(j + margin, j + n - margin);
    for (int m = 0; m < 50; ++m) {
      const double x = x0 + u(random) * dx, y = y0 + v(random) * dy;
      const auto a = whole.at(x, y), b = w.at(x, y);
      ASSERT_EQ(a.h, b.h);
      ASSERT_EQ(a.hx, b.hx);
      ASSERT_EQ(a.hy, b.hy);
      ASSERT_EQ(whole.valid(x, y), w.valid(x, y));
    }
  }
}

TEST(Window, WithoutSamplesIsFlatAtZero) {
  const Window w;
  EXPECT_TRUE(w.empty());
  EXPECT_EQ(w.at(3, 4).h, 0);
  EXPECT_FALSE(w.valid(3, 4));
  EXPECT_EQ(w.bounds(area(0, 0, 1, 1)), (Interval{0, 0}));
  EXPECT_EQ(w.slope(area(0, 0, 1, 1)), 0);
}

TEST(Window, HasNoDataFarOutsideAndStaysFinite) {
  const auto w = rough(8, 6, 1, 1);
  EXPECT_FALSE(w.valid(1e18, -1e18));
  EXPECT_TRUE(std::isfinite(w.height(1e18, -1e300)));
  EXPECT_TRUE(w.bounds(Box::everywhere()).contains(w.height(0, 15)));
}

}  // namespace
}  // namespace hoodoo::dem
