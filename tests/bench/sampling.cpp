#include "tests/bench/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/base/sampling.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {
namespace {

constexpr double extent = 5200, thickness = 8;  // [m] of Karst in Paris et al. 2019, table 1
constexpr double sphere_radius = 5.99;          // [m] makes about its 165,773 spheres

/// A height field with the least and greatest height of ever larger squares of its cells.
class Surface {
 public:
  Surface() {
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        z_.push_back(200.0 + 150.0 * static_cast<double>(
                                         fractal(static_cast<float>(i), static_cast<float>(j))));
      }
    }
    levels_.push_back({cells, {}});
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i) {
        const auto [low, high] =
            std::minmax({at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        levels_[0].ranges.emplace_back(low, high);
      }
    }
    while (levels_.back().side > 1) levels_.push_back(halved(levels_.back()));
  }

  double height(double x, double y) const {
    const double u = std::clamp(x / cell, 0.0, cells - 1e-6),
                 v = std::clamp(y / cell, 0.0, cells - 1e-6);
    const int i = static_cast<int>(u), j = static_cast<int>(v);
    const double s = u - i, t = v - j;
    return (at(i, j) * (1 - s) + at(i + 1, j) * s) * (1 - t) +
           (at(i, j + 1) * (1 - s) + at(i + 1, j + 1) * s) * t;
  }
  bool in_shell(double x, double y, double z) const {
    const double h = height(x, y);
    return z <= h && z >= h - thickness;
  }
  /// Whether the shell may pass through the box, by at most nine squares.
  bool may_meet(const Box& box) const {
    const auto index = [](double v) {
      return static_cast<int>(std::clamp(v / cell, 0.0, cells - 1.0));
    };
    int i1 = index(box.min.x), i2 = index(box.max.x), j1 = index(box.min.y), j2 = index(box.max.y);
    std::size_t level = 0;
    for (; std::max(i2 - i1, j2 - j1) > 2; ++level) i1 /= 2, i2 /= 2, j1 /= 2, j2 /= 2;
    const auto& squares = levels_[level];
    double low = Box::infinity, high = -Box::infinity;
    for (int j = j1; j <= j2; ++j) {
      for (int i = i1; i <= i2; ++i) {
        const auto& range = squares.ranges[static_cast<std::size_t>(j * squares.side + i)];
        low = std::min(low, range.first), high = std::max(high, range.second);
      }
    }
    return box.max.z >= low - thickness && box.min.z <= high;
  }

 private:
  static constexpr int cells = 1300;
  static constexpr double cell = extent / cells;
  struct Level {
    int side;
    std::vector<std::pair<double, double>> ranges;
  };

  double at(int i, int j) const { return z_[static_cast<std::size_t>(j * (cells + 1) + i)]; }
  static Level halved(const Level& fine) {
    Level coarse{(fine.side + 1) / 2, {}};
    for (int j = 0; j < coarse.side; ++j) {
      for (int i = 0; i < coarse.side; ++i) {
        std::pair<double, double> range{Box::infinity, -Box::infinity};
        for (int y = 2 * j; y < std::min(2 * j + 2, fine.side); ++y) {
          for (int x = 2 * i; x < std::min(2 * i + 2, fine.side); ++x) {
            const auto& part = fine.ranges[static_cast<std::size_t>(y * fine.side + x)];
            range = {std::min(range.first, part.first), std::max(range.second, part.second)};
          }
        }
        coarse.ranges.push_back(range);
      }
    }
    return coarse;
  }

  std::vector<double> z_;
  std::vector<Level> levels_;
};

/// Darts one after the other, each kept if none before it lies too near: cells that hold one sphere
/// each, in a hash table. Darts fall into the shell by its height.
class PlainDarts {
 public:
  PlainDarts(const Surface& surface, double radius)
      : surface_(surface), apart_(2 * radius), side_(apart_ / std::sqrt(3.0)) {}

  /// Darts thrown for so many spheres.
  std::int64_t run(std::size_t wanted, std::int64_t most) {
    keys_.assign(std::size_t{1} << 20, ~std::uint64_t{0});
    values_.resize(keys_.size());
    std::int64_t n = 0;
    for (; kept_.size() < wanted && n < most; ++n) {
      const auto real = [n](int axis) { return unit_real(random_bits(3, n, axis)); };
      const double x = extent * real(0), y = extent * real(1);
      keep_if_free({x, y, surface_.height(x, y) - thickness * real(2)});
    }
    return n;
  }
  std::size_t size() const { return kept_.size(); }

 private:
  std::uint64_t key(const Vec3& p, int i, int j, int k) const {
    const auto along = [this](double v, int by) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(v / side_) + 8 + by) & 0x1fffff;
    };
    return along(p.x, i) << 42 | along(p.y, j) << 21 | along(p.z, k);
  }
  std::size_t slot(std::uint64_t key) const {
    auto at = (key * 0x9e3779b97f4a7c15U) >> 44;
    while (keys_[at] != ~std::uint64_t{0} && keys_[at] != key) at = (at + 1) & (keys_.size() - 1);
    return at;
  }
  void keep_if_free(const Vec3& p) {
    for (int k = -2; k <= 2; ++k) {
      for (int j = -2; j <= 2; ++j) {
        for (int i = -2; i <= 2; ++i) {
          const auto at = slot(key(p, i, j, k));
          if (keys_[at] == ~std::uint64_t{0}) continue;
          const Vec3 d = kept_[values_[at]] - p;
          if (dot(d, d) < apart_ * apart_) return;
        }
      }
    }
    const auto at = slot(key(p, 0, 0, 0));
    keys_[at] = key(p, 0, 0, 0);
    values_[at] = static_cast<std::uint32_t>(kept_.size());
    kept_.push_back(p);
  }

  const Surface& surface_;
  double apart_, side_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> values_;
  std::vector<Vec3> kept_;
};

}  // namespace

void compare_sampling() {
  const Surface surface;
  PoissonSphere spheres;
  spheres.seed = 1;
  spheres.radius_least = spheres.radius_most = sphere_radius;
  spheres.radius = [&](double x, double y, double z) {
    return surface.in_shell(x, y, z) ? sphere_radius : 0;
  };
  spheres.may_hold = [&](const Box& box) { return surface.may_meet(box); };
  std::size_t count = poisson_sphere(spheres, {{0, 0, -100}, {extent, extent, 500}}).size();
  const std::size_t wanted = count * 3 / 4;
  std::size_t plain_count = 0;
  std::int64_t thrown = 0;
  const auto [seconds, plain] = median_seconds(
      [&] {
        count = poisson_sphere(spheres, {{0, 0, -100}, {extent, extent, 500}}).size();
      },
      [&] {
        PlainDarts darts(surface, sphere_radius);
        thrown = darts.run(wanted, 20'000'000);
        plain_count = darts.size();
      });
  fmt::print("spheres of {} m in a shell of {} m over {} x {} m\n", sphere_radius, thickness,
             extent, extent);
  fmt::print("  ours, maximal: {} spheres {:.3f} s\n", count, seconds);
  fmt::print("  plain darts, to three quarters of that: {} spheres of {} darts {:.3f} s\n",
             plain_count, thrown, plain);
  ratio("sampling: seconds for a maximal set", seconds, "<= 0.6");
  ratio("sampling: a maximal set / plain darts to three quarters", seconds / plain, "to compare");
}

}  // namespace hoodoo::bench
