#include "engine/generator/site.hpp"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/base/error.hpp"
#include "engine/tree/polygon.hpp"

namespace hoodoo::generator {
namespace {

/// Points are asked for in blocks of so many spacings: few fields, each of few primitives.
constexpr double block_spacings = 32;
/// Rows of elevations that are read at once.
constexpr std::int32_t rows_at_once = 64;
constexpr float none = std::numeric_limits<float>::quiet_NaN();

using BlockKey = std::array<std::int64_t, 3>;

/// A run of points of one block, as indices into a list.
struct Run {
  BlockKey block;
  std::size_t from, to;
};

std::int64_t whole(double v) { return static_cast<std::int64_t>(std::floor(v)); }

}  // namespace

std::optional<std::size_t> Elevations::cell(double px, double py) const {
  const double i = std::floor((px - x0) / pixel), j = std::floor((py - y0) / pixel);
  if (!(i >= 0 && j >= 0 && i < grid.width && j < grid.height)) return std::nullopt;
  return grid.index(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
}

double Elevations::between(std::span<const float> values, double px, double py) const {
  const double u = (px - x0) / pixel - 0.5, v = (py - y0) / pixel - 0.5;
  const auto i = static_cast<std::int32_t>(std::floor(u));
  const auto j = static_cast<std::int32_t>(std::floor(v));
  double sum = 0, weights = 0;
  for (std::int32_t b = 0; b < 2; ++b) {
    for (std::int32_t a = 0; a < 2; ++a) {
      if (!grid.holds(i + a, j + b)) continue;
      const float value = values[grid.index(i + a, j + b)];
      if (std::isnan(value)) continue;
      const double w = (a == 0 ? i + 1 - u : u - i) * (b == 0 ? j + 1 - v : v - j);
      sum += w * static_cast<double>(value);
      weights += w;
    }
  }
  return weights > 0 ? sum / weights : 0;
}

Site::Site(tree::Ground& ground, std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
           double spacing, const Box& extent, Spend spend)
    : ground_(ground),
      pyramids_(pyramids),
      spacing_(spacing),
      extent_(extent),
      spend_(std::move(spend)),
      pixel_(std::numeric_limits<double>::infinity()) {
  for (std::size_t i = 0; i < pyramids.size(); ++i) {
    if (ground.bodies[i].inverted) continue;
    const auto& level = pyramids[i]->levels().front();
    pixel_ = std::min({pixel_, level.dx, level.dy});
  }
  if (!std::isfinite(pixel_)) pixel_ = spacing;
}

Box Site::terrain_extent() const {
  Box all;
  for (std::size_t i = 0; i < pyramids_.size(); ++i) {
    if (!ground_.bodies[i].inverted) all.add(pyramids_[i]->extent());
  }
  return all;
}

std::vector<dem::Window> Site::windows(const Box& area) const {
  std::vector<dem::Window> windows;
  windows.reserve(pyramids_.size());
  for (const auto& pyramid : pyramids_) {
    windows.push_back(pyramid->window(pyramid->level_for(spacing_), area));
  }
  return windows;
}

std::unique_ptr<const tree::Field> Site::compile(const Box& box,
                                                 std::span<const dem::Window> windows) const {
  return tree::compile(ground_, windows, box.min, box);
}

Site::Block Site::compile(const Box& box) const {
  Block block{windows(box), nullptr};
  block.field = compile(box, block.windows);
  return block;
}

void Site::in_parallel(std::size_t count, const std::function<void(std::size_t)>& work) const {
  tbb::task_arena arena(spend_.threads);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (auto i = range.begin(); i < range.end(); ++i) {
            if (spend_.stop.stop_requested()) throw Error(Fault::cancelled, "", "cancelled");
            work(i);
          }
        },
        tbb::simple_partitioner());
  });
}

/// Calls ask(field, indices, points relative to the block) for every block that holds some.
template <class Ask>
void Site::by_blocks(std::span<const Vec3> at, const Ask& ask) const {
  const double size = block_spacings * spacing_;
  std::vector<BlockKey> keys(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    keys[i] = {whole(at[i].x / size), whole(at[i].y / size), whole(at[i].z / size)};
  }
  std::vector<std::size_t> order(at.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return keys[i]; });
  std::vector<Run> runs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (runs.empty() || runs.back().block != keys[order[i]]) runs.push_back({keys[order[i]], i, i});
    runs.back().to = i + 1;
  }
  in_parallel(runs.size(), [&](std::size_t r) {
    const auto& run = runs[r];
    const Vec3 origin{static_cast<double>(run.block[0]) * size,
                      static_cast<double>(run.block[1]) * size,
                      static_cast<double>(run.block[2]) * size};
    const auto block = compile({origin, origin + Vec3{size, size, size}});
    const auto count = run.to - run.from;
    std::vector<float> x(count), y(count), z(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 p = at[order[run.from + i]] - origin;
      x[i] = static_cast<float>(p.x);
      y[i] = static_cast<float>(p.y);
      z[i] = static_cast<float>(p.z);
    }
    ask(*block.field, std::span(order).subspan(run.from, count), tree::Points{x, y, z});
  });
}

std::vector<Site::Value> Site::values(std::span<const Vec3> at) const {
  std::vector<Value> values(at.size());
  by_blocks(at, [&](const tree::Field& field, std::span<const std::size_t> which,
                    const tree::Points& points) {
    const auto n = points.size();
    std::vector<float> f(n), gx(n), gy(n), gz(n), rho(n);
    field.gradients(points, f, {gx, gy, gz});
    field.resistances(points, rho);
    for (std::size_t i = 0; i < n; ++i) {
      values[which[i]] = {
          f[i],
          {static_cast<double>(gx[i]), static_cast<double>(gy[i]), static_cast<double>(gz[i])},
          rho[i]};
    }
  });
  return values;
}

std::vector<float> Site::resistances(std::span<const Vec3> at) const {
  std::vector<float> values(at.size());
  by_blocks(at, [&](const tree::Field& field, std::span<const std::size_t> which,
                    const tree::Points& points) {
    std::vector<float> rho(points.size());
    field.resistances(points, rho);
    for (std::size_t i = 0; i < rho.size(); ++i) values[which[i]] = rho[i];
  });
  return values;
}

bool Site::covered(std::span<const dem::Window> windows, double x, double y) const {
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const auto& body = ground_.bodies[i];
    if (body.inverted || windows[i].empty() || !windows[i].valid(x, y)) continue;
    if (body.domain.empty() || tree::edge_distance(body.domain, x, y).d >= 0) return true;
  }
  return false;
}

std::optional<Interval> Site::heights(const Box& area) const {
  std::optional<Interval> all;
  for (std::size_t i = 0; i < pyramids_.size(); ++i) {
    if (ground_.bodies[i].inverted) continue;
    const auto one = pyramids_[i]->bounds(pyramids_[i]->level_for(spacing_), area);
    if (!one) continue;
    const double offset = ground_.bodies[i].offset;
    const Interval moved{one->low + offset, one->high + offset};
    all = all ? Interval{std::min(all->low, moved.low), std::max(all->high, moved.high)} : moved;
  }
  return all;
}

void Site::fill_row(const Elevations& into, std::int32_t j, std::span<const double> x,
                    std::span<const dem::Window> windows, float* out) const {
  const double y = into.y(j);
  std::vector<double> h(x.size());
  std::vector<std::uint8_t> valid(x.size());
  std::fill_n(out, x.size(), none);
  for (std::size_t b = 0; b < windows.size(); ++b) {
    const auto& body = ground_.bodies[b];
    if (body.inverted || windows[b].empty()) continue;
    windows[b].valid(x, {&y, 1}, valid);
    windows[b].grid(x, {&y, 1}, {h, {}, {}});
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (valid[i] == 0 || !std::isnan(out[i])) continue;
      if (!body.domain.empty() && tree::edge_distance(body.domain, x[i], y).d < 0) continue;
      out[i] = static_cast<float>(h[i] + body.offset);
    }
  }
}

Elevations Site::elevations(const Box& area, double pixel, std::size_t bytes_per_cell) const {
  Elevations made;
  made.pixel = pixel;
  const auto i0 = whole(area.min.x / pixel), j0 = whole(area.min.y / pixel);
  const auto width = whole(area.max.x / pixel) - i0 + 1;
  const auto height = whole(area.max.y / pixel) - j0 + 1;
  const auto cells = static_cast<double>(width) * static_cast<double>(height);
  if (cells * static_cast<double>(bytes_per_cell) > static_cast<double>(spend_.memory)) {
    throw Error(Fault::limit, "",
                fmt::format("elevations of {} x {} cells take {:.0f} MiB, the limit is {} MiB",
                            width, height, cells * static_cast<double>(bytes_per_cell) / (1 << 20),
                            spend_.memory >> 20));
  }
  made.x0 = static_cast<double>(i0) * pixel;
  made.y0 = static_cast<double>(j0) * pixel;
  auto& grid = made.grid;
  grid.width = static_cast<std::int32_t>(width);
  grid.height = static_cast<std::int32_t>(height);
  grid.z.resize(static_cast<std::size_t>(cells));
  grid.dx.assign(static_cast<std::size_t>(height), pixel);
  grid.dy.assign(static_cast<std::size_t>(height), pixel);
  std::vector<double> x(static_cast<std::size_t>(width));
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = made.x(static_cast<std::int32_t>(i));
  const auto strips = static_cast<std::size_t>((grid.height + rows_at_once - 1) / rows_at_once);
  in_parallel(strips, [&](std::size_t s) {
    const auto from = static_cast<std::int32_t>(s) * rows_at_once;
    const auto to = std::min(from + rows_at_once, grid.height);
    const auto near = windows({{x.front(), made.y(from), 0}, {x.back(), made.y(to - 1), 0}});
    for (auto j = from; j < to; ++j) fill_row(made, j, x, near, &grid.z[grid.index(0, j)]);
  });
  return made;
}

}  // namespace hoodoo::generator
