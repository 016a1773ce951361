#include "engine/generator/surface_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/error.hpp"
#include "engine/base/random.hpp"

namespace hoodoo::generator {
namespace {

constexpr std::int64_t side = 15;        // cells along a block: its points fill one cube of fields
constexpr std::size_t corners = 16;      // points along it
constexpr std::size_t rounds = 4;        // candidates of a cell
constexpr int newton_steps = 3;          // of a candidate on its cell's corners
constexpr int settle_steps = 3;          // then on the field itself
constexpr double settled_within = 0.02;  // of F = 1/2
constexpr std::size_t taken_at_once = 1024;  // cells, by one thread
constexpr std::size_t most_columns = 16'000'000;
constexpr std::int64_t farthest_cell = 1 << 20;  // what a cell's key has bits for

using Cell = std::array<std::int64_t, 3>;

/// For hashes.
std::uint64_t key_of(const Cell& c) {
  std::uint64_t key = 0;
  for (const auto v : c) key = key << 21 | static_cast<std::uint64_t>(v + farthest_cell);
  return key;
}

/// What is common to many draws is mixed once: random_bits(a, b, c) is
/// further_bits(random_bits(a, b), c).
std::uint64_t further_bits(std::uint64_t bits, std::uint64_t next) {
  return mix(bits ^ (next + 0x9e3779b97f4a7c15U));
}

/// F at the corners of a cell, x slowest.
using Corners = std::array<double, 8>;

struct Linear {
  double value;
  Vec3 slope;  // per cell
};
Linear trilinear(const Corners& f, const Vec3& u) {
  std::array<double, 4> x{}, dx{};  // along x, for (y, z)
  for (std::size_t i = 0; i < 4; ++i) {
    dx[i] = f[4 + i] - f[i];
    x[i] = f[i] + u.x * dx[i];
  }
  const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
  const double low = mix(x[0], x[2], u.y), high = mix(x[1], x[3], u.y);
  return {mix(low, high, u.z),
          {mix(mix(dx[0], dx[2], u.y), mix(dx[1], dx[3], u.y), u.z),
           mix(x[2] - x[0], x[3] - x[1], u.z), high - low}};
}

/// Whether the surface faces up everywhere in the cell, its normal's upward part above the root of
/// `squared_level`: slopes lie between those of the cell's edges.
bool is_level(const Corners& f, double squared_level) {
  double rise = -Box::infinity, x = 0, y = 0;
  for (std::size_t n = 0; n < 4; ++n) {
    const std::size_t below = 2 * n, front = (n >> 1) * 4 + (n & 1);
    rise = std::max(rise, f[below + 1] - f[below]);
    x = std::max(x, std::abs(f[n + 4] - f[n]));
    y = std::max(y, std::abs(f[front + 2] - f[front]));
  }
  return rise < 0 && rise * rise > squared_level * (rise * rise + x * x + y * y);
}

/// Calls visit(i, j, k) for the cells of a block that the surface passes through: a part of their
/// corners is inside. The values of its points, x slowest.
template <class Visit>
void for_each_crossed(std::span<const float> f, const Visit& visit) {
  constexpr auto plane = corners * corners;
  std::array<std::uint8_t, corners * plane> inside{};
  for (std::size_t n = 0; n < inside.size(); ++n) inside[n] = f[n] > 0.5F ? 1 : 0;
  for (std::size_t i = 0; i + 1 < corners; ++i) {
    for (std::size_t j = 0; j + 1 < corners; ++j) {
      const std::uint8_t* at = &inside[i * plane + j * corners];
      std::array<std::uint8_t, corners> sums{};  // of the four points of each height
      for (std::size_t k = 0; k < corners; ++k) {
        sums[k] = static_cast<std::uint8_t>(at[k] + at[corners + k] + at[plane + k] +
                                            at[plane + corners + k]);
      }
      for (std::size_t k = 0; k + 1 < corners; ++k) {
        const int sum = sums[k] + sums[k + 1];
        if (sum > 0 && sum < 8) visit(i, j, k);
      }
    }
  }
}

/// A cell that the surface passes through, and its candidates on the surface of its corners.
struct Passed {
  Cell cell;
  std::array<Vec3, rounds> at{};
  std::array<bool, rounds> good{};
};

class Sampler {
 public:
  Sampler(const Site& site, const SurfaceSampling& sampling)
      : site_(site), sampling_(sampling), size_(sampling.distance) {
    const double level = 0.5 * (1 + sampling.level);
    squared_level_ = level * level;
    for (const auto& step : site.ground().steps) {
      reaches_.push_back(tree::support(step.tree).influence);
    }
  }

  std::vector<SurfaceSample> run() {
    find_cells();
    find_neighbours();
    for (std::size_t round = 0; round < rounds; ++round) {
      for (const auto& cells : by_phase_) take(cells, round);
    }
    return settled();
  }

 private:
  /// Cells whose samples can matter to those in the box: three further on each side.
  Box cells_reach() const { return sampling_.box.grown(3 * size_); }

  void find_cells() {
    const Box box = cells_reach();
    const double block = static_cast<double>(side) * size_;
    const auto at = [&](double v) { return static_cast<std::int64_t>(std::floor(v / block)); };
    const auto x0 = at(box.min.x), x1 = at(box.max.x), y0 = at(box.min.y), y1 = at(box.max.y);
    if (x1 < x0 || y1 < y0) return;
    const auto wide = static_cast<std::size_t>(x1 - x0 + 1);
    const auto count = wide * static_cast<std::size_t>(y1 - y0 + 1);
    const double most = static_cast<double>(farthest_cell) * size_;
    if (count > most_columns || std::abs(box.min.x) > most || std::abs(box.max.x) > most ||
        std::abs(box.min.y) > most || std::abs(box.max.y) > most) {
      throw Error(Fault::limit, "",
                  fmt::format("samples {} m apart over x [{:.0f}, {:.0f}] m, y [{:.0f}, {:.0f}] m "
                              "are too many",
                              size_, box.min.x, box.max.x, box.min.y, box.max.y));
    }
    std::vector<std::vector<Passed>> found(count);
    site_.in_parallel(count, [&](std::size_t n) {
      find_in_column(x0 + static_cast<std::int64_t>(n % wide),
                     y0 + static_cast<std::int64_t>(n / wide), box, found[n]);
    });
    for (const auto& some : found) cells_.insert(cells_.end(), some.begin(), some.end());
    std::ranges::sort(cells_, {}, &Passed::cell);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      std::size_t phase = 0;
      for (const auto v : cells_[i].cell)
        phase = 3 * phase + static_cast<std::size_t>(((v % 3) + 3) % 3);
      by_phase_[phase].push_back(i);
      std::uint8_t good = 0;
      for (std::size_t n = 0; n < rounds; ++n) {
        if (cells_[i].good[n]) good |= static_cast<std::uint8_t>(1U << n);
      }
      good_.push_back(good);
    }
    taken_.assign(cells_.size(), 0);
  }

  void find_in_column(std::int64_t bx, std::int64_t by, const Box& box,
                      std::vector<Passed>& into) const {
    const double block = static_cast<double>(side) * size_;
    Box column{
        {static_cast<double>(bx) * block, static_cast<double>(by) * block, box.min.z},
        {static_cast<double>(bx + 1) * block, static_cast<double>(by + 1) * block, box.max.z}};
    if (sampling_.wanted && !sampling_.wanted(column)) return;
    const auto windows = site_.windows(column);
    if (!narrow(column, windows)) return;
    const auto z0 = static_cast<std::int64_t>(std::floor(column.min.z / block));
    const auto z1 = static_cast<std::int64_t>(std::floor(column.max.z / block));
    for (auto bz = z0; bz <= z1; ++bz) {
      const Vec3 low{column.min.x, column.min.y, static_cast<double>(bz) * block};
      const Box around{low, low + Vec3{block, block, block}};
      const auto field = site_.compile(around, windows);
      const auto bounds = field->bounds();
      if (bounds.low > 0.5 || bounds.high <= 0.5) continue;
      find_in_block({side * bx, side * by, side * bz}, low, *field, windows, into);
    }
  }

  /// Where no step reaches a column, its surface lies between its elevations. False: none does.
  bool narrow(Box& column, std::span<const dem::Window> windows) const {
    if (std::ranges::any_of(reaches_, [&](const Box& b) { return b.overlaps(column); }))
      return true;
    double low = Box::infinity, high = -Box::infinity;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      if (windows[i].empty()) continue;
      const auto h = windows[i].bounds(column);
      const double offset = site_.ground().bodies[i].offset;
      low = std::min(low, h.low + offset);
      high = std::max(high, h.high + offset);
    }
    column.min.z = std::max(column.min.z, low - size_);
    column.max.z = std::min(column.max.z, high + size_);
    return column.min.z <= column.max.z;
  }

  void find_in_block(const Cell& first, const Vec3& low, const tree::Field& field,
                     std::span<const dem::Window> windows, std::vector<Passed>& into) const {
    std::array<float, corners> along{};
    for (std::size_t i = 0; i < corners; ++i) {
      along[i] = static_cast<float>(static_cast<double>(i) * size_);
    }
    std::vector<float> f(corners * corners * corners);
    field.grid({along, along, along}, f);
    const auto before = into.size();
    for_each_crossed(f, [&](std::size_t i, std::size_t j, std::size_t k) {
      Corners c{};
      for (std::size_t n = 0; n < 8; ++n) {
        c[n] = static_cast<double>(
            f[((i + (n >> 2)) * corners + j + (n >> 1 & 1)) * corners + k + (n & 1)]);
      }
      if (is_level(c, squared_level_)) return;
      Passed passed{{first[0] + static_cast<std::int64_t>(i),
                     first[1] + static_cast<std::int64_t>(j),
                     first[2] + static_cast<std::int64_t>(k)}};
      const Vec3 corner =
          low +
          Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)} * size_;
      if (draw(c, corner, windows, passed)) into.push_back(passed);
    });
    settle(field, low, std::span(into).subspan(before));
    const auto settled = into.begin() + static_cast<std::ptrdiff_t>(before);
    into.erase(
        std::remove_if(settled, into.end(),
                       [](const Passed& p) { return std::ranges::count(p.good, true) == 0; }),
        into.end());
  }

  /// Candidates moved to F = 1/2 itself; those that leave their cells are none.
  void settle(const tree::Field& field, const Vec3& low, std::span<Passed> passed) const {
    std::vector<std::pair<Passed*, std::size_t>> moving;
    for (auto& one : passed) {
      for (std::size_t n = 0; n < rounds; ++n) {
        if (one.good[n]) moving.emplace_back(&one, n);
      }
    }
    const auto count = moving.size();
    std::vector<float> x(count), y(count), z(count), f(count), gx(count), gy(count), gz(count);
    const auto place = [&] {
      for (std::size_t m = 0; m < count; ++m) {
        const Vec3 p = moving[m].first->at[moving[m].second] - low;
        x[m] = static_cast<float>(p.x);
        y[m] = static_cast<float>(p.y);
        z[m] = static_cast<float>(p.z);
      }
    };
    place();
    for (int step = 0; step < settle_steps; ++step) {
      field.gradients({x, y, z}, f, {gx, gy, gz});
      for (std::size_t m = 0; m < count; ++m) {
        const Vec3 slope{static_cast<double>(gx[m]), static_cast<double>(gy[m]),
                         static_cast<double>(gz[m])};
        const double steep = dot(slope, slope);
        if (!(steep > 0)) continue;
        const Vec3 move = slope * ((0.5 - static_cast<double>(f[m])) / steep);
        const double far = length(move), most = 0.5 * size_;
        auto& at = moving[m].first->at[moving[m].second];
        at = at + (far > most ? move * (most / far) : move);
      }
      place();
    }
    field.gradients({x, y, z}, f, {gx, gy, gz});
    for (std::size_t m = 0; m < count; ++m) {
      const auto [one, n] = moving[m];
      bool good = std::abs(static_cast<double>(f[m]) - 0.5) <= settled_within;
      for (int a = 0; a < 3; ++a) {
        good = good && std::floor(one->at[n][a] / size_) ==
                           static_cast<double>(one->cell[static_cast<std::size_t>(a)]);
      }
      const Vec3 slope{static_cast<double>(gx[m]), static_cast<double>(gy[m]),
                       static_cast<double>(gz[m])};
      one->good[n] = good && normalized(-slope).z <= sampling_.level;
    }
  }

  /// Candidates by hash, drawn to the surface within the cell. False: none is there.
  bool draw(const Corners& f, const Vec3& corner, std::span<const dem::Window> windows,
            Passed& into) const {
    const auto of_cell = random_bits(sampling_.seed, key_of(into.cell));
    bool any = false;
    for (std::size_t n = 0; n < rounds; ++n) {
      const auto own = further_bits(of_cell, n);
      Vec3 u{unit_real(further_bits(own, 0)), unit_real(further_bits(own, 1)),
             unit_real(further_bits(own, 2))};
      bool on = false;
      for (int step = 0; step < newton_steps; ++step) {
        const auto at = trilinear(f, u);
        const double off = at.value - 0.5, steep = dot(at.slope, at.slope);
        if (!(steep > 0)) break;
        const Vec3 moved = u - at.slope * (off / steep);
        on = moved.x >= 0 && moved.x < 1 && moved.y >= 0 && moved.y < 1 && moved.z >= 0 &&
             moved.z < 1;
        on = on && (at.slope.z >= 0 || at.slope.z * at.slope.z <= squared_level_ * steep);
        u = {std::clamp(moved.x, 0.0, 1.0), std::clamp(moved.y, 0.0, 1.0),
             std::clamp(moved.z, 0.0, 1.0)};
      }
      into.at[n] = corner + u * size_;
      into.good[n] = on && (!sampling_.within || sampling_.within(into.at[n])) &&
                     site_.covered(windows, into.at[n].x, into.at[n].y);
      any = any || into.good[n];
    }
    return any;
  }

  /// Lists for each cell those around it and itself. The cells are in order, so that of one of the
  /// nine columns around a cell those of its height follow each other, after those of any cell
  /// before it.
  void find_neighbours() {
    std::array<std::size_t, 9> from{};
    neighbours_from_.reserve(cells_.size() + 1);
    for (const auto& passed : cells_) {
      neighbours_from_.push_back(neighbours_.size());
      const auto [x, y, z] = passed.cell;
      for (std::size_t n = 0; n < from.size(); ++n) {
        const Cell low{x + static_cast<std::int64_t>(n / 3) - 1,
                       y + static_cast<std::int64_t>(n % 3) - 1, z - 1};
        const Cell high{low[0], low[1], z + 1};
        while (from[n] < cells_.size() && cells_[from[n]].cell < low) ++from[n];
        for (auto i = from[n]; i < cells_.size() && cells_[i].cell <= high; ++i) {
          neighbours_.push_back(static_cast<std::uint32_t>(i));
        }
      }
    }
    neighbours_from_.push_back(neighbours_.size());
  }

  bool is_free(std::size_t cell, const Vec3& p) const {
    for (auto i = neighbours_from_[cell]; i < neighbours_from_[cell + 1]; ++i) {
      const unsigned taken = taken_[neighbours_[i]];
      if (taken == 0) continue;
      const auto& other = cells_[neighbours_[i]];
      for (std::size_t n = 0; n < rounds; ++n) {
        if ((taken >> n & 1U) == 0) continue;
        const Vec3 d = other.at[n] - p;
        if (dot(d, d) < size_ * size_) return false;
      }
    }
    return true;
  }

  /// Of cells of one phase none is around another: they are taken side by side.
  void take(std::span<const std::size_t> cells, std::size_t round) {
    site_.in_parallel((cells.size() + taken_at_once - 1) / taken_at_once, [&](std::size_t part) {
      const auto rest = cells.subspan(part * taken_at_once);
      for (const auto i : rest.first(std::min(rest.size(), taken_at_once))) take(i, round);
    });
  }
  void take(std::size_t i, std::size_t round) {
    if ((good_[i] >> round & 1U) == 0 || !is_free(i, cells_[i].at[round])) return;
    taken_[i] |= static_cast<std::uint8_t>(1U << round);
  }

  /// The samples in the box, with the field's own normal.
  std::vector<SurfaceSample> settled() const {
    std::vector<Vec3> at;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      for (std::size_t n = 0; n < rounds; ++n) {
        const bool taken = (taken_[i] >> n & 1U) != 0;
        if (taken && sampling_.box.contains(cells_[i].at[n])) at.push_back(cells_[i].at[n]);
      }
    }
    const auto values = site_.values(at);
    std::vector<SurfaceSample> samples;
    samples.reserve(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) {
      samples.push_back({at[i], normalized(-values[i].gradient), values[i].resistance});
    }
    return samples;
  }

  const Site& site_;
  const SurfaceSampling& sampling_;
  double size_;
  double squared_level_;      // no candidate where the corners are far more level than asked for
  std::vector<Box> reaches_;  // of the steps so far
  std::vector<Passed> cells_;
  // A bit for each candidate of a cell: small, as it is asked for far more often than their places.
  std::vector<std::uint8_t> good_, taken_;
  std::vector<std::uint32_t> neighbours_;     // of the first cell, then of the next, and so on
  std::vector<std::size_t> neighbours_from_;  // where those of a cell begin
  std::array<std::vector<std::size_t>, 27> by_phase_;
};

}  // namespace

std::vector<SurfaceSample> sample_surface(const Site& site, const SurfaceSampling& sampling) {
  if (sampling.box.empty()) return {};
  return Sampler(site, sampling).run();
}

}  // namespace hoodoo::generator
