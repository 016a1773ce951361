#include "tests/bench/sampling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/base/random.hpp"
#include "engine/base/sampling.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/scene.hpp"

namespace hoodoo::bench {
namespace {

constexpr double extent = 5200, thickness = 8;  // [m] of Karst in Paris et al. 2019, table 1
constexpr double sphere_radius = 6.045;         // [m] makes about its 165,773 spheres

/// A height field, bilinear between the corners of its cells.
class Surface {
 public:
  Surface() {
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        z_.push_back(200.0 + 150.0 * static_cast<double>(
                                         fractal(static_cast<float>(i), static_cast<float>(j))));
      }
    }
  }

  double height(double x, double y) const {
    const double u = along(x), v = along(y);
    const int i = static_cast<int>(u), j = static_cast<int>(v);
    return between(i, j, u - i, v - j);
  }
  /// The least and greatest height over a box: of its corners, and of where it meets the lines
  /// between cells.
  Interval heights(const Box& box) const {
    Interval all{Box::infinity, -Box::infinity};
    const double u0 = along(box.min.x), v0 = along(box.min.y);
    const double u1 = along(box.max.x), v1 = along(box.max.y);
    const int x = static_cast<int>(u0), y = static_cast<int>(v0);
    if (u1 <= x + 1 && v1 <= y + 1) {  // within a cell
      const double z = at(x, y), along_x = at(x + 1, y) - z, along_y = at(x, y + 1) - z;
      const double twist = at(x + 1, y + 1) - z - along_x - along_y;
      const auto row = [&](double t) -> std::array<double, 2> {
        const double from = z + t * along_y, rise = along_x + t * twist;
        return {from + (u0 - x) * rise, from + (u1 - x) * rise};
      };
      const auto [a, b] = row(v0 - y);
      const auto [c, d] = row(v1 - y);
      return {std::min(std::min(a, b), std::min(c, d)), std::max(std::max(a, b), std::max(c, d))};
    }
    for (double v = v0; v < v1; v = std::floor(v) + 1) add_row(v, u0, u1, all);
    add_row(v1, u0, u1, all);
    return all;
  }

 private:
  static constexpr int cells = 1300;
  static constexpr double cell = extent / cells;

  /// Of a line along x: its ends, and where it meets the lines between cells.
  void add_row(double v, double u0, double u1, Interval& all) const {
    const int j = static_cast<int>(v), first = static_cast<int>(u0), last = static_cast<int>(u1);
    const double t = v - j;
    const auto height = [&](int i) { return at(i, j) + t * (at(i, j + 1) - at(i, j)); };
    const auto add = [&all](double h) { all = {std::min(all.low, h), std::max(all.high, h)}; };
    double left = height(first), right = height(first + 1);
    add(left + (u0 - first) * (right - left));
    for (int i = first; i < last; ++i) {
      add(right);
      left = right;
      right = height(i + 2);
    }
    add(left + (u1 - last) * (right - left));
  }
  double between(int i, int j, double s, double t) const {
    const double low = at(i, j), right = at(i + 1, j), up = at(i, j + 1);
    return low + s * (right - low) + t * (up - low + s * (at(i + 1, j + 1) - up - right + low));
  }
  static double along(double v) { return std::clamp(v / cell, 0.0, cells - 1e-6); }
  double at(int i, int j) const { return z_[static_cast<std::size_t>(j * (cells + 1) + i)]; }

  std::vector<double> z_;
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
  PoissonShell shell;
  shell.seed = 1;
  shell.radius_least = shell.radius_most = sphere_radius;
  shell.thickness = thickness;
  shell.top = [&](double x, double y) { return surface.height(x, y); };
  shell.tops = [&](const Box& box) { return surface.heights(box); };
  const Box region{{0, 0, 0}, {extent, extent, 0}};
  std::size_t count = poisson_shell(shell, region).size();
  const std::size_t wanted = count * 3 / 4;
  std::size_t plain_count = 0;
  std::int64_t thrown = 0;
  const auto [seconds, plain] = median_seconds([&] { count = poisson_shell(shell, region).size(); },
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
