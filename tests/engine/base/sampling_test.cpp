#include "engine/base/sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <thread>
#include <tuple>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"

namespace hoodoo {
namespace {

struct Ball {
  Vec3 center;
  double radius;
};
std::vector<Ball> balls_of(const std::vector<DiskSample>& samples) {
  std::vector<Ball> balls;
  for (const auto& s : samples) balls.push_back({{s.x, s.y, 0}, s.radius});
  return balls;
}
std::vector<Ball> balls_of(const std::vector<SphereSample>& samples) {
  std::vector<Ball> balls;
  for (const auto& s : samples) balls.push_back({s.center, s.radius});
  return balls;
}

/// Which balls lie too near, by cells of a lattice of its own.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Ball>& balls, double radius_most)
      : balls_(balls), side_(2 * radius_most) {
    for (std::size_t n = 0; n < balls.size(); ++n) cells_[cell(balls[n].center)].push_back(n);
  }
  /// Balls closer to `p` than the sum of both radii.
  int conflicts(const Vec3& p, double radius) const {
    int count = 0;
    const auto [x, y, z] = cell(p);
    for (int n = 0; n < 27; ++n) {
      const auto found = cells_.find({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
      if (found == cells_.end()) continue;
      for (const auto b : found->second) {
        count += static_cast<int>(length(balls_[b].center - p) < balls_[b].radius + radius);
      }
    }
    return count;
  }
  int pairs() const {
    int count = 0;
    for (const auto& b : balls_) count += conflicts(b.center, b.radius) - 1;
    return count / 2;
  }

 private:
  using Cell = std::tuple<int, int, int>;
  Cell cell(const Vec3& p) const {
    const auto along = [this](double v) { return static_cast<int>(std::floor(v / side_)); };
    return {along(p.x), along(p.y), along(p.z)};
  }
  const std::vector<Ball>& balls_;
  double side_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Of so many darts into the box, those that fall where they may, and those that find room there.
template <class Radius>
std::array<int, 2> darts(const Neighbourhood& all, const Box& box, int count, Radius radius) {
  std::array<int, 2> result{};
  for (int n = 0; n < count; ++n) {
    const auto real = [&](int axis) {
      return box.min[axis] + (box.max[axis] - box.min[axis]) * unit_real(random_bits(7, n, axis));
    };
    const Vec3 p{real(0), real(1), real(2)};
    const double r = radius(p);
    if (r <= 0) continue;
    ++result[0];
    result[1] += static_cast<int>(all.conflicts(p, r) == 0);
  }
  return result;
}

constexpr int million = 1'000'000;

TEST(PoissonDisk, OfOneRadiusKeepsItsDistanceAndLeavesNoRoom) {
  PoissonDisk disks;
  disks.seed = 11;
  const auto balls = balls_of(poisson_disk(disks, {{-100, -70, 0}, {100, 130, 0}}));
  const Neighbourhood all(balls, 1);
  EXPECT_EQ(all.pairs(), 0);
  const auto [thrown, room] =
      darts(all, {{-98, -68, 0}, {98, 128, 0}}, million, [](const Vec3&) { return 1; });
  EXPECT_EQ(thrown, million);
  EXPECT_EQ(room, 0);
  // Random sequential adsorption of disks ends at 0.547: Feder 1980.
  EXPECT_NEAR(static_cast<double>(balls.size()) * pi / 40'000, 0.547, 0.006);
}

double tenfold(double x, double y) {
  return 1 + 9 * (0.5 + 0.5 * std::clamp(0.03 * (x - 0.5 * y), -1.0, 1.0));
}

TEST(PoissonDisk, OfTenfoldRadiiKeepsTheSumOfBothAndLeavesNoRoom) {
  PoissonDisk disks;
  disks.seed = 5;
  disks.radius_most = 10;
  disks.radius = tenfold;
  const auto balls = balls_of(poisson_disk(disks, {{-150, -150, 0}, {150, 150, 0}}));
  const Neighbourhood all(balls, 10);
  EXPECT_EQ(all.pairs(), 0);
  const auto [thrown, room] = darts(all, {{-130, -130, 0}, {130, 130, 0}}, million,
                                    [](const Vec3& p) { return tenfold(p.x, p.y); });
  EXPECT_EQ(thrown, million);
  EXPECT_EQ(room, 0);
}

TEST(PoissonDisk, StaysWhereItMayAndFillsThat) {
  PoissonDisk disks;
  disks.seed = 3;
  const auto radius = [](double x, double y) { return x * x + y * y < 1600 ? 1.0 : -1.0; };
  disks.radius = radius;
  const Box region{{-60, -60, 0}, {60, 60, 0}};
  const auto samples = poisson_disk(disks, region);
  const auto balls = balls_of(samples);
  for (const auto& b : balls) EXPECT_GT(radius(b.center.x, b.center.y), 0);
  const auto [thrown, room] = darts(Neighbourhood(balls, 1), region, million,
                                    [&](const Vec3& p) { return radius(p.x, p.y); });
  EXPECT_GT(thrown, million / 4);
  EXPECT_EQ(room, 0);
  disks.may_hold = [](const Box& b) {
    const double x = std::clamp(0.0, b.min.x, b.max.x), y = std::clamp(0.0, b.min.y, b.max.y);
    return x * x + y * y < 1600;
  };
  EXPECT_EQ(poisson_disk(disks, region), samples) << "may_hold changes nothing";
}

/// Under a wavy surface, 3 m thick.
double shell_radius(double x, double y, double z) {
  const double h = 4 * std::sin(0.1 * x) + 3 * std::sin(0.13 * y);
  return z <= h && z >= h - 3 ? 1 : 0;
}

TEST(PoissonSphere, FillsAShellUnderASurface) {
  PoissonSphere spheres;
  spheres.seed = 2;
  spheres.radius = shell_radius;
  const auto balls = balls_of(poisson_sphere(spheres, {{0, 0, -20}, {50, 50, 20}}));
  const Neighbourhood all(balls, 1);
  EXPECT_EQ(all.pairs(), 0);
  for (const auto& b : balls) EXPECT_GT(shell_radius(b.center.x, b.center.y, b.center.z), 0);
  const auto [thrown, room] = darts(all, {{2, 2, -10}, {48, 48, 8}}, million,
                                    [](const Vec3& p) { return shell_radius(p.x, p.y, p.z); });
  EXPECT_GT(thrown, million / 10);
  EXPECT_EQ(room, 0);
}

double wavy(double x, double y) { return 4 * std::sin(0.1 * x) + 3 * std::sin(0.13 * y); }

/// 3 m under the wavy surface, but for a hole in it.
PoissonShell wavy_shell() {
  PoissonShell shell;
  shell.seed = 6;
  shell.thickness = 3;
  shell.top = [](double x, double y) {
    return x * x + y * y < 36 ? std::numeric_limits<double>::quiet_NaN() : wavy(x, y);
  };
  shell.tops = [](const Box& box) -> Interval {
    const double far_x = std::max(-box.min.x, box.max.x), far_y = std::max(-box.min.y, box.max.y);
    if (far_x * far_x + far_y * far_y < 36) return {1, -1};
    const double half_x = 0.5 * (box.max.x - box.min.x), half_y = 0.5 * (box.max.y - box.min.y);
    const double middle = wavy(box.min.x + half_x, box.min.y + half_y);
    const double rise = 0.4 * half_x + 0.39 * half_y;
    return {middle - rise, middle + rise};
  };
  return shell;
}

double radius_of(const PoissonShell& shell, const Vec3& p) {
  if (std::isnan(p.z)) return 0;
  return shell.radius ? shell.radius(p.x, p.y, p.z) : shell.radius_least;
}

/// Of a million darts into the shell's columns, those that fall where they may, and those that
/// find room there.
std::array<int, 2> darts(const PoissonShell& shell, const Neighbourhood& all, double from,
                         double to) {
  std::array<int, 2> result{};
  for (int n = 0; n < million; ++n) {
    const auto real = [n](int axis) { return unit_real(random_bits(8, n, axis)); };
    const double x = from + (to - from) * real(0), y = from + (to - from) * real(1);
    const Vec3 p{x, y, shell.top(x, y) - shell.thickness * real(2)};
    const double r = radius_of(shell, p);
    if (r <= 0) continue;
    ++result[0];
    result[1] += static_cast<int>(all.conflicts(p, r) == 0);
  }
  return result;
}

/// Samples lie in the shell, keep the sum of their radii, and leave no room.
void expect_maximal(const PoissonShell& shell) {
  const auto samples = poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}});
  EXPECT_GT(samples.size(), 500U);
  for (const auto& s : samples) {
    const double depth = shell.top(s.center.x, s.center.y) - s.center.z;
    EXPECT_GE(depth, -1e-9);
    EXPECT_LE(depth, shell.thickness + 1e-9);
    EXPECT_EQ(s.radius, radius_of(shell, s.center));
  }
  const auto balls = balls_of(samples);
  const Neighbourhood all(balls, shell.radius_most);
  EXPECT_EQ(all.pairs(), 0);
  const auto [thrown, room] = darts(shell, all, -34, 34);
  EXPECT_GT(thrown, million / 2);
  EXPECT_EQ(room, 0);
}

TEST(PoissonShell, OfOneRadiusKeepsItsDistanceAndLeavesNoRoom) { expect_maximal(wavy_shell()); }

TEST(PoissonShell, OfThreefoldRadiiKeepsTheSumOfBothAndLeavesNoRoom) {
  auto shell = wavy_shell();
  shell.radius_most = 3;
  shell.radius = [](double x, double y, double z) {
    return 1 + 2 * (0.5 + 0.5 * std::clamp(0.03 * (x - 0.5 * y + z), -1.0, 1.0));
  };
  expect_maximal(shell);
}

TEST(PoissonShell, FillsOnlyWhatItsRadiusAllows) {
  auto shell = wavy_shell();
  shell.radius = [](double x, double y, double) { return x + y > 3 ? 1.0 : -1.0; };
  for (const auto& s : poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}})) {
    EXPECT_GT(s.center.x + s.center.y, 3);
  }
  const auto balls = balls_of(poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}}));
  const auto [thrown, room] = darts(shell, Neighbourhood(balls, 1), -38, 38);
  EXPECT_GT(thrown, million / 4);
  EXPECT_EQ(room, 0);
}

/// The samples of a square cut into so many times so many, put together by two threads.
std::vector<SphereSample> in_tiles(const PoissonShell& shell, int tiles) {
  std::array<std::vector<SphereSample>, 2> parts;
  {
    std::vector<std::jthread> pool;
    for (int t = 0; t < 2; ++t) {
      pool.emplace_back([&, t] {
        const double side = 80.0 / tiles;
        for (int n = t; n < tiles * tiles; n += 2) {
          const double x = -40 + side * (n % tiles), y = -40 + side * (n / tiles);
          const auto part = poisson_shell(shell, {{x, y, 0}, {x + side, y + side, 0}});
          auto& own = parts[static_cast<std::size_t>(t)];
          own.insert(own.end(), part.begin(), part.end());
        }
      });
    }
  }
  auto all = parts[0];
  all.insert(all.end(), parts[1].begin(), parts[1].end());
  std::ranges::sort(all, {}, [](const SphereSample& s) {
    return std::tuple(s.center.x, s.center.y, s.center.z);
  });
  return all;
}

TEST(PoissonShell, IsTheSameHoweverThePlaneIsCut) {
  auto shell = wavy_shell();
  for (const bool varies : {false, true}) {
    if (varies) {
      shell.radius_most = 3;
      shell.slope = 0.1;
      shell.radius = [](double x, double, double z) {
        return std::clamp(2 + 0.04 * x + 0.05 * z, 1.0, 3.0);
      };
    }
    const auto whole = poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}});
    EXPECT_GT(whole.size(), 200U);
    EXPECT_EQ(in_tiles(shell, 1), whole);
    EXPECT_EQ(in_tiles(shell, 4), whole);
    EXPECT_EQ(in_tiles(shell, 7), whole);
  }
  const auto before = poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}});
  shell.seed = 7;
  EXPECT_NE(poisson_shell(shell, {{-40, -40, 0}, {40, 40, 0}}), before);
}

/// The samples of a square cut into so many times so many, put together by any number of threads.
std::vector<DiskSample> in_tiles(const PoissonDisk& disks, int tiles, unsigned threads) {
  std::vector<std::vector<DiskSample>> parts(threads);
  {
    std::vector<std::jthread> pool;
    for (unsigned t = 0; t < threads; ++t) {
      pool.emplace_back([&, t] {
        const double side = 160.0 / tiles;
        for (int n = static_cast<int>(t); n < tiles * tiles; n += static_cast<int>(threads)) {
          const double x = -80 + side * (n % tiles), y = -80 + side * (n / tiles);
          const auto part = poisson_disk(disks, {{x, y, 0}, {x + side, y + side, 0}});
          parts[t].insert(parts[t].end(), part.begin(), part.end());
        }
      });
    }
  }
  std::vector<DiskSample> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  std::ranges::sort(all, {}, [](const DiskSample& s) { return std::tuple(s.x, s.y); });
  return all;
}

TEST(PoissonDisk, IsTheSameHoweverThePlaneIsCut) {
  for (const bool varies : {false, true}) {
    PoissonDisk disks;
    disks.seed = 77;
    if (varies) disks.radius_most = 10, disks.radius = tenfold;
    const auto whole = in_tiles(disks, 1, 1);
    EXPECT_GT(whole.size(), 100U);
    EXPECT_EQ(in_tiles(disks, 4, 1), whole);
    EXPECT_EQ(in_tiles(disks, 16, 1), whole);
    EXPECT_EQ(in_tiles(disks, 16, 2), whole);
  }
}

TEST(PoissonDisk, LooksNoFurtherThanAFewCellsBeyondItsRegion) {
  PoissonDisk disks;
  disks.seed = 4;
  double furthest = 0;
  disks.radius = [&](double x, double y) {
    furthest = std::max({furthest, -x, -y, x - 100, y - 100});
    return 1;
  };
  poisson_disk(disks, {{0, 0, 0}, {100, 100, 0}});
  EXPECT_LT(furthest, 10 * 2) << "cells are as wide as the exclusion distance";
}

TEST(PoissonSphere, IsTheSameHoweverSpaceIsCut) {
  PoissonSphere spheres;
  spheres.seed = 9;
  spheres.radius = shell_radius;
  const auto whole = poisson_sphere(spheres, {{-24, -24, -12}, {24, 24, 12}});
  std::vector<SphereSample> parts;
  for (int n = 0; n < 64; ++n) {
    const Vec3 low{-24 + 12.0 * (n % 4), -24 + 12.0 * (n / 4 % 4), -12 + 6.0 * (n / 16)};
    const auto part = poisson_sphere(spheres, {low, low + Vec3{12, 12, 6}});
    parts.insert(parts.end(), part.begin(), part.end());
  }
  std::ranges::sort(parts, {}, [](const SphereSample& s) {
    return std::tuple(s.center.x, s.center.y, s.center.z);
  });
  EXPECT_EQ(parts, whole);
}

/// Mean of |sum of e^(2 pi i f p)|^2 / n over the frequencies f of a square of this side with
/// low <= |f| < high, none of them 0.
double mean_power(const std::vector<DiskSample>& samples, double side, double low, double high) {
  double sum = 0;
  int count = 0;
  const int most = static_cast<int>(high * side) + 1;
  for (int a = 0; a <= most; a += 2) {
    for (int b = -most; b <= most; b += 2) {
      const double f = std::hypot(a, b) / side;
      if (f < low || f >= high || f == 0) continue;
      std::complex<double> wave = 0;
      for (const auto& s : samples) wave += std::polar(1.0, 2 * pi * (a * s.x + b * s.y) / side);
      sum += std::norm(wave) / static_cast<double>(samples.size());
      ++count;
    }
  }
  return sum / count;
}

TEST(PoissonDisk, HasTheSpectrumOfBlueNoise) {
  PoissonDisk disks;
  disks.seed = 21;
  constexpr double side = 100, per_distance = 1 / 2.0;  // 1 / (2 r)
  const auto samples = poisson_disk(disks, {{0, 0, 0}, {side, side, 0}});
  EXPECT_LT(mean_power(samples, side, 0, 0.5 * per_distance), 0.12);
  EXPECT_NEAR(mean_power(samples, side, 2 * per_distance, 2.2 * per_distance), 1, 0.25);
  EXPECT_NEAR(mean_power(samples, side, 3 * per_distance, 3.1 * per_distance), 1, 0.25);
}

TEST(PoissonShell, SoThinThatItIsAPlaneHasTheSpectrumOfBlueNoise) {
  PoissonShell shell;
  shell.seed = 22;
  shell.thickness = 0.01;
  shell.top = [](double, double) { return 5; };
  shell.tops = [](const Box&) -> Interval { return {5, 5}; };
  constexpr double side = 100, per_distance = 1 / 2.0;  // 1 / (2 r)
  std::vector<DiskSample> samples;
  for (const auto& s : poisson_shell(shell, {{0, 0, 0}, {side, side, 0}})) {
    samples.push_back({s.center.x, s.center.y, s.radius, s.id});
  }
  EXPECT_NEAR(static_cast<double>(samples.size()) * pi / (side * side), 0.547, 0.012);
  EXPECT_LT(mean_power(samples, side, 0, 0.5 * per_distance), 0.12);
  EXPECT_NEAR(mean_power(samples, side, 2 * per_distance, 2.2 * per_distance), 1, 0.25);
  EXPECT_NEAR(mean_power(samples, side, 3 * per_distance, 3.1 * per_distance), 1, 0.25);
}

}  // namespace
}  // namespace hoodoo
