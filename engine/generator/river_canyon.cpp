#include "engine/generator/river_canyon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/hydrology/hydrology.hpp"

namespace hoodoo::generator {
namespace {

/// What the water's way takes: elevations twice, receivers, areas, slopes, stress and bed.
constexpr std::size_t bytes_per_cell = hydrology::bytes_per_cell + 24;
/// The bend at a place is seen over so many widths of the banks.
constexpr double bend_reach = 2;
/// The bed's centroid lies this share of that reach inside a sharp bend.
constexpr double sharp_bend = 0.25;

double bump(double d, double reach) {
  const double left = std::max(1 - d * d / (reach * reach), 0.0);
  return left * left * left;
}

/// The value below which `percent` of the valid cells lie.
double percentile_of(std::span<const float> values, double percent) {
  std::vector<float> sorted;
  sorted.reserve(values.size());
  std::ranges::copy_if(values, std::back_inserter(sorted), [](float v) { return !std::isnan(v); });
  if (sorted.empty()) return 0;
  const auto last = static_cast<double>(sorted.size() - 1);
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(percent / 100 * last));
  std::ranges::nth_element(sorted, sorted.begin() + at);
  return static_cast<double>(sorted[static_cast<std::size_t>(at)]);
}

/// The river in plan: the stress around its beds, and how high they lie there.
class River {
 public:
  River(const RiverCanyon& canyon, const Site& site) : canyon_(canyon) {
    const double pixel = canyon.pixel > 0 ? canyon.pixel : site.pixel();
    ground_ = site.elevations(site.terrain_extent(), pixel, bytes_per_cell);
    find_bed();
    spread();
  }

  std::size_t bed_cells() const { return bed_.size(); }
  void mark(std::vector<Mark>& into) const {
    const auto wide = static_cast<std::size_t>(ground_.grid.width);
    for (const auto& q : bed_) {
      into.push_back({{ground_.x(static_cast<std::int32_t>(q.cell % wide)),
                       ground_.y(static_cast<std::int32_t>(q.cell / wide)), q.z},
                      q.stress});
    }
  }

  /// In [0, 1].
  double stress(const Vec3& p) const {
    const double s = std::min(ground_.between(stress_, p.x, p.y), 1.0);
    if (s <= 0) return 0;
    return s * bump(std::max(p.z - ground_.between(level_, p.x, p.y), 0.0), canyon_.flood);
  }

  /// A column holds some of it.
  bool reaches(const Box& column) const {
    const auto from = [&](double v, double v0) {
      return static_cast<std::int32_t>(
          std::clamp(std::floor((v - v0) / ground_.pixel) - 1, -1e9, 1e9));
    };
    const auto& grid = ground_.grid;
    const auto i0 = std::max(from(column.min.x, ground_.x0), 0);
    const auto i1 = std::min(from(column.max.x, ground_.x0) + 2, grid.width - 1);
    const auto j0 = std::max(from(column.min.y, ground_.y0), 0);
    const auto j1 = std::min(from(column.max.y, ground_.y0) + 2, grid.height - 1);
    for (auto j = j0; j <= j1; ++j) {
      for (auto i = i0; i <= i1; ++i) {
        if (stress_[grid.index(i, j)] > 0) return true;
      }
    }
    return false;
  }

 private:
  struct BedCell {
    std::size_t cell;
    double stress, z;
    double bend_x, bend_y;  // into the bend, 1 where it is sharp
  };

  void find_bed() {
    auto filled = ground_.grid;
    hydrology::fill(filled);
    const auto drainage =
        hydrology::accumulate(filled, hydrology::receivers(filled, hydrology::Routing::freeman));
    filled = {};
    const auto power = hydrology::stream_power(drainage, hydrology::slope(ground_.grid));
    const double most = percentile_of(power, canyon_.percentile);
    if (!(most > 0)) return;
    for (std::size_t cell = 0; cell < power.size(); ++cell) {
      const double s = std::min(static_cast<double>(power[cell]) / most, 1.0);
      if (!(s > canyon_.stress) || static_cast<double>(drainage.area[cell]) < canyon_.drainage) {
        continue;
      }
      bed_.push_back({cell, s, static_cast<double>(ground_.grid.z[cell]), 0, 0});
    }
  }

  /// Calls visit(cell, dx, dy) for the cells at most `reach` from a cell; dx, dy from there [m].
  template <class Visit>
  void around(std::size_t cell, double reach, const Visit& visit) const {
    const auto& grid = ground_.grid;
    const auto wide = static_cast<std::size_t>(grid.width);
    const auto i = static_cast<std::int32_t>(cell % wide);
    const auto j = static_cast<std::int32_t>(cell / wide);
    const auto far = static_cast<std::int32_t>(std::floor(reach / ground_.pixel));
    for (auto b = -far; b <= far; ++b) {
      for (auto a = -far; a <= far; ++a) {
        if (!grid.holds(i + a, j + b)) continue;
        visit(grid.index(i + a, j + b), a * ground_.pixel, b * ground_.pixel);
      }
    }
  }

  void find_bends() {
    std::vector<float> weight(ground_.grid.size());
    for (const auto& q : bed_) weight[q.cell] = static_cast<float>(q.stress);
    const double reach = bend_reach * canyon_.banks;
    for (auto& q : bed_) {
      double sum = 0, x = 0, y = 0;
      around(q.cell, reach, [&](std::size_t other, double dx, double dy) {
        if (weight[other] <= 0 || dx * dx + dy * dy > reach * reach) return;
        const auto w = static_cast<double>(weight[other]);
        sum += w;
        x += w * dx;
        y += w * dy;
      });
      const double scale = 1 / (sum * sharp_bend * reach);
      x *= scale;
      y *= scale;
      const double far = std::sqrt(x * x + y * y);
      q.bend_x = far > 1 ? x / far : x;
      q.bend_y = far > 1 ? y / far : y;
    }
  }

  /// The convolution, scaled so that a straight bed one cell wide keeps its stress.
  void spread() {
    find_bends();
    const double reach = canyon_.banks;
    double line = 1;
    for (double d = ground_.pixel; d < reach; d += ground_.pixel) line += 2 * bump(d, reach);
    std::vector<double> sums(ground_.grid.size()), heights(ground_.grid.size());
    for (const auto& q : bed_) {
      around(q.cell, reach, [&](std::size_t other, double dx, double dy) {
        const double d = std::sqrt(dx * dx + dy * dy), k = bump(d, reach) * q.stress / line;
        if (k <= 0) return;
        // Of the unit vector away from the bed along the one into the bend.
        const double inward = d > 0 ? (dx * q.bend_x + dy * q.bend_y) / d : 0;
        sums[other] += k * (1 - canyon_.outer * inward);
        heights[other] += k * (1 - canyon_.outer * inward) * q.z;
      });
    }
    stress_.resize(sums.size());
    level_.resize(sums.size(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < sums.size(); ++i) {
      stress_[i] = static_cast<float>(sums[i]);
      if (sums[i] > 0) level_[i] = static_cast<float>(heights[i] / sums[i]);
    }
  }

  const RiverCanyon& canyon_;
  Elevations ground_;
  std::vector<BedCell> bed_;
  std::vector<float> stress_, level_;
};

}  // namespace

void RiverCanyon::grow(Growth& growth) const {
  const River river(*this, growth.site);
  river.mark(growth.record.list("bed"));
  growth.record.count("bed cells", river.bed_cells());
  const double flat = bit_cos(steepness * pi / 180);  // upward part of the normals of beds
  SurfaceSampling sampling{growth.reach(), distance, 0, flat, {}, {}};
  sampling.wanted = [&](const Box& column) { return river.reaches(column); };
  sampling.within = [&](const Vec3& p) { return river.stress(p) > 0; };
  for (int step = 0; step < steps; ++step) {
    sampling.seed = random_bits(growth.seed, step);
    std::vector<Stressed> stressed;
    for (const auto& sample : sample_surface(growth.site, sampling)) {
      stressed.push_back({sample, river.stress(sample.at)});
    }
    erode(*this, stressed, growth);
  }
}

}  // namespace hoodoo::generator
