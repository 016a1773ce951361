#include "tiling/slice/land.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "engine/base/random.hpp"
#include "tiling/slice/closed.hpp"
#include "tiling/slice/lanes.hpp"

namespace hoodoo::slice {
namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}

/// Whether a body can be solid over (x, y): always, but for one with a domain, near that.
bool may_cover(const tree::HeightBody& body, double x, double y) {
  if (body.domain.empty()) return true;
  Box box;
  for (const auto& corner : body.domain) box.add(Vec3{corner[0], corner[1], 0});
  box = box.grown(body.falloff);
  return x >= box.min.x && x <= box.max.x && y >= box.min.y && y <= box.max.y;
}

}  // namespace

std::size_t Land::BlockHash::operator()(const BlockIndex& b) const {
  return static_cast<std::size_t>(random_bits(static_cast<std::uint64_t>(b.x), b.y, b.z));
}

Land::Land(const Slice& slice, std::span<const std::shared_ptr<const dem::Pyramid>> pyramids)
    : slice_(slice) {
  const Box area = reach(slice.lattice, slice.key);
  for (std::size_t i = 0; i < pyramids.size(); ++i) {
    windows_.push_back(pyramids[i]->window(slice.elevations[i].level, area));
  }
}

const tree::Field& Land::field(const BlockIndex& block) {
  auto& field = fields_[block];
  if (!field) {
    const double size = block_cells * slice_.spacing();
    const Vec3 origin = Vec3{static_cast<double>(block.x), static_cast<double>(block.y),
                             static_cast<double>(block.z)} *
                        size;
    field =
        tree::compile(slice_.ground, windows_, origin, {origin, origin + Vec3{size, size, size}});
    if (is_closed()) field = closed_at(block, origin, std::move(field));
  }
  return *field;
}

std::unique_ptr<const tree::Field> Land::closed_at(const BlockIndex& block, const Vec3& origin,
                                                   std::unique_ptr<const tree::Field> field) const {
  std::array<std::array<bool, block_cells + 2>, block_cells + 2> columns{};  // from -1 on
  for (std::int64_t j = 0; j < block_cells + 2; ++j) {
    for (std::int64_t i = 0; i < block_cells + 2; ++i) {
      columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)] =
          in_world(block.x * block_cells + i - 1, block.y * block_cells + j - 1);
    }
  }
  Closure closure{slice_.spacing(), *slice_.floor - origin.z, {}};
  for (std::size_t j = 0; j <= block_cells; ++j) {
    for (std::size_t i = 0; i <= block_cells; ++i) {
      closure.inside[j][i] =
          columns[j][i] && columns[j][i + 1] && columns[j + 1][i] && columns[j + 1][i + 1];
    }
  }
  return closed(std::move(field), closure);
}

bool Land::in_world(std::int64_t i, std::int64_t j) const {
  const double x = (static_cast<double>(i) + 0.5) * slice_.spacing();
  const double y = (static_cast<double>(j) + 0.5) * slice_.spacing();
  const Box& world = slice_.world;
  if (x < world.min.x || x > world.max.x || y < world.min.y || y > world.max.y) return false;
  for (std::size_t b = 0; b < windows_.size(); ++b) {
    if (windows_[b].valid(x, y) && may_cover(slice_.ground.bodies[b], x, y)) return true;
  }
  return false;
}

void Land::in_world(std::int64_t i, std::int64_t j, std::size_t wide,
                    std::span<std::uint8_t> out) const {
  std::vector<double> x(wide), y(out.size() / wide);
  for (std::size_t p = 0; p < x.size(); ++p) {
    x[p] = (static_cast<double>(i + static_cast<int>(p)) + 0.5) * slice_.spacing();
  }
  for (std::size_t q = 0; q < y.size(); ++q) {
    y[q] = (static_cast<double>(j + static_cast<int>(q)) + 0.5) * slice_.spacing();
  }
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  std::vector<std::uint8_t> of_body(out.size());
  for (std::size_t b = 0; b < windows_.size(); ++b) {
    windows_[b].valid(x, y, of_body);
    const auto& body = slice_.ground.bodies[b];
    for (std::size_t n = 0; n < out.size() && !body.domain.empty(); ++n) {
      if (!may_cover(body, x[n % wide], y[n / wide])) of_body[n] = 0;
    }
    std::transform(out.begin(), out.end(), of_body.begin(), out.begin(), std::bit_or<>());
  }
  const Box& world = slice_.world;
  // The columns of each row that are within the world's extent.
  const auto from = std::lower_bound(x.begin(), x.end(), world.min.x) - x.begin();
  const auto to = std::upper_bound(x.begin() + from, x.end(), world.max.x) - x.begin();
  for (std::size_t q = 0; q < y.size(); ++q) {
    const bool inside = y[q] >= world.min.y && y[q] <= world.max.y;
    const auto row = out.begin() + static_cast<std::ptrdiff_t>(wide * q);
    std::fill(row, row + (inside ? from : static_cast<std::ptrdiff_t>(wide)), std::uint8_t{0});
    if (inside) std::fill(row + to, row + static_cast<std::ptrdiff_t>(wide), std::uint8_t{0});
  }
}

Interval Land::heights(const Box& area) const {
  Interval range{Box::infinity, -Box::infinity};
  for (std::size_t b = 0; b < windows_.size(); ++b) {
    if (windows_[b].empty()) continue;
    const double offset = slice_.ground.bodies[b].offset;
    range = hull(range, windows_[b].bounds(area) + Interval{offset, offset});
  }
  return range;
}

Interval Land::heights_at(double x, double y) const {
  Interval range{Box::infinity, -Box::infinity};
  for (std::size_t b = 0; b < windows_.size(); ++b) {
    if (windows_[b].empty() || !may_cover(slice_.ground.bodies[b], x, y)) continue;
    const double h = windows_[b].height(x, y) + slice_.ground.bodies[b].offset;
    range = hull(range, {h, h});
  }
  return range;
}

Vec3 Land::metres(const StepPoint& p) const {
  return Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])} *
         slice_.step();
}

BlockIndex Land::owner(const StepPoint& p) const {
  const std::int64_t size = std::int64_t{block_cells} * slice_.lattice.units();
  return {floor_divide(p[0], size), floor_divide(p[1], size), floor_divide(p[2], size)};
}

std::vector<Land::Run> Land::runs_of(std::span<const StepPoint> points) const {
  const std::int64_t size = std::int64_t{block_cells} * slice_.lattice.units();
  const auto holds = [size](const BlockIndex& b, const StepPoint& p) {
    const auto inside = [size](std::int64_t at, std::int64_t block) {
      return at >= block * size && at < (block + 1) * size;
    };
    return inside(p[0], b.x) && inside(p[1], b.y) && inside(p[2], b.z);
  };
  std::vector<Run> runs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (runs.empty() || !holds(runs.back().block, points[i])) {
      runs.push_back({owner(points[i]), i, i});
    }
    runs.back().to = i + 1;
  }
  return runs;
}

/// Visits runs of points that one block owns; those of one block together, unless they come in few
/// runs anyhow, as the vertices of a surface do.
template <class Visit>
void Land::by_owner(std::span<const StepPoint> points, Visit visit) {
  auto runs = runs_of(points);
  if (runs.size() > points.size() / 16) {
    std::stable_sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
      return std::array{a.block.z, a.block.y, a.block.x} <
             std::array{b.block.z, b.block.y, b.block.x};
    });
  }
  const std::int64_t size = std::int64_t{block_cells} * slice_.lattice.units();
  const auto step = static_cast<float>(slice_.step());
  std::vector<float> x, y, z;
  std::vector<std::uint32_t> order;
  for (std::size_t from = 0, to = 0; from < runs.size(); from = to) {
    const BlockIndex block = runs[from].block;
    x.clear(), y.clear(), z.clear(), order.clear();
    for (; to < runs.size() && runs[to].block == block; ++to) {
      for (std::size_t i = runs[to].from; i < runs[to].to; ++i) {
        const auto& p = points[i];
        order.push_back(static_cast<std::uint32_t>(i));
        x.push_back(static_cast<float>(p[0] - block.x * size) * step);
        y.push_back(static_cast<float>(p[1] - block.y * size) * step);
        z.push_back(static_cast<float>(p[2] - block.z * size) * step);
      }
    }
    visit(block, std::span<const std::uint32_t>(order), tree::Points{x, y, z});
  }
}

std::vector<Vec3f> Land::normals(std::span<const StepPoint> points) {
  std::vector<Vec3f> normals(points.size());
  std::vector<float> value, gx, gy, gz;
  by_owner(points, [&](const BlockIndex& block, auto indices, const tree::Points& at) {
    const auto n = at.size();
    value.resize(n), gx.resize(n), gy.resize(n), gz.resize(n);
    evaluations_ += n;
    field(block).gradients(at, value, {gx, gy, gz});
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 out = normalized({-gx[i], -gy[i], -gz[i]});
      normals[indices[i]] = {static_cast<float>(out.x), static_cast<float>(out.y),
                             static_cast<float>(out.z)};
    }
  });
  return normals;
}

namespace {

constexpr std::size_t batch = 256;  // points whose numbers stay in the nearest cache
using Numbers = std::array<double, batch>;

/// Points of a block, counted from `low`, those of one part of 4^3 cells after those of another:
/// what stands near some of them mostly stands near all.
std::vector<std::uint32_t> by_part(std::span<const std::array<std::int32_t, 3>> points,
                                   const std::array<std::int32_t, 3>& low, std::int32_t units) {
  std::vector<std::uint8_t> parts(points.size());
  std::array<std::uint32_t, 65> first{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    int part = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const std::int32_t at = points[i][a] - low[a];
      part = 4 * part + (at >= 4 * units ? 1 : 0) + (at >= 8 * units ? 1 : 0) +
             (at >= 12 * units ? 1 : 0);
    }
    parts[i] = static_cast<std::uint8_t>(part);
    ++first[static_cast<std::size_t>(part) + 1];
  }
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<std::uint32_t> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    order[first[parts[i]]++] = static_cast<std::uint32_t>(i);
  return order;
}

}  // namespace

void Land::steps_to_ground(const dem::Window& window, const StepPoint& origin, Offsets points,
                           std::size_t to, Moves& out) const {
  const std::array<double, 3> from{static_cast<double>(origin[0]), static_cast<double>(origin[1]),
                                   static_cast<double>(origin[2])};
  const double step = slice_.step();
  Numbers x, y, z, h, hx, hy, down;
  down.fill(-1);
  for (std::size_t first = 0; first < points.size(); first += batch) {
    const std::size_t n = std::min(batch, points.size() - first);
    const auto part = [n](Numbers& all) { return std::span(all).first(n); };
    to_metres(points.subspan(first, n), from, step, {part(x), part(y), part(z)});
    window.at(part(x), part(y), {part(h), part(hx), part(hy)});
    for (std::size_t i = 0; i < n; ++i) h[i] -= z[i];
    const auto put = [&](std::vector<double>& all) {
      return std::span(all).subspan(to + first, n);
    };
    newton_steps(part(h), {part(hx), part(hy), part(down)}, {put(out.x), put(out.y), put(out.z)});
  }
}

void Land::steps_in_block(const BlockIndex& block, const StepPoint& origin, Offsets points,
                          std::size_t to, Moves& out) {
  const std::int64_t size = std::int64_t{block_cells} * slice_.lattice.units();
  std::array<std::int32_t, 3> low{};
  const std::array<std::int64_t, 3> corner{block.x, block.y, block.z};
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = static_cast<std::int32_t>(corner[a] * size - origin[a]);
  }
  const auto order = by_part(points, low, slice_.lattice.units());
  const auto step = static_cast<float>(slice_.step());
  const tree::Field& owner = field(block);
  evaluations_ += points.size();
  std::array<std::array<float, batch>, 3> at, gradient;
  std::array<float, batch> value;
  Numbers above, gx, gy, gz, x, y, z;
  for (std::size_t first = 0; first < order.size(); first += batch) {
    const std::size_t n = std::min(batch, order.size() - first);
    for (std::size_t i = 0; i < n; ++i) {
      const auto& p = points[order[first + i]];
      for (std::size_t a = 0; a < 3; ++a) at[a][i] = static_cast<float>(p[a] - low[a]) * step;
    }
    owner.gradients({{at[0].data(), n}, {at[1].data(), n}, {at[2].data(), n}}, {value.data(), n},
                    {{gradient[0].data(), n}, {gradient[1].data(), n}, {gradient[2].data(), n}});
    for (std::size_t i = 0; i < n; ++i) {
      above[i] = static_cast<double>(value[i]) - 0.5;
      gx[i] = static_cast<double>(gradient[0][i]);
      gy[i] = static_cast<double>(gradient[1][i]);
      gz[i] = static_cast<double>(gradient[2][i]);
    }
    const auto part = [n](Numbers& all) { return std::span(all).first(n); };
    newton_steps(part(above), {part(gx), part(gy), part(gz)}, {part(x), part(y), part(z)});
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t put = to + order[first + i];
      out.x[put] = x[i], out.y[put] = y[i], out.z[put] = z[i];
    }
  }
}

void Land::steps_to_surface(const StepPoint& origin, Offsets points, Moves& out) {
  for (auto* all : {&out.x, &out.y, &out.z}) all->resize(points.size());
  const auto size = static_cast<std::int32_t>(block_cells * slice_.lattice.units());
  for (std::size_t first = 0, last = 0; first < points.size(); first = last) {
    const auto& p = points[first];
    const BlockIndex block = owner({origin[0] + p[0], origin[1] + p[1], origin[2] + p[2]});
    const std::array<std::int64_t, 3> low{block.x * size - origin[0], block.y * size - origin[1],
                                          block.z * size - origin[2]};
    const auto holds = [&](const std::array<std::int32_t, 3>& q) {
      const auto inside = [&](std::size_t a) {
        return static_cast<std::uint64_t>(q[a] - low[a]) < static_cast<std::uint64_t>(size);
      };
      return inside(0) && inside(1) && inside(2);
    };
    while (last < points.size() && holds(points[last])) ++last;
    const auto run = points.subspan(first, last - first);
    if (const dem::Window* window = field(block).height_field()) {
      steps_to_ground(*window, origin, run, first, out);
    } else {
      steps_in_block(block, origin, run, first, out);
    }
  }
}

std::vector<float> Land::resistances(std::span<const StepPoint> points) {
  std::vector<float> result(points.size()), value;
  by_owner(points, [&](const BlockIndex& block, auto indices, const tree::Points& at) {
    value.resize(at.size());
    field(block).resistances(at, value);
    for (std::size_t i = 0; i < at.size(); ++i) result[indices[i]] = value[i];
  });
  return result;
}

std::vector<float> Land::values(std::span<const StepPoint> points) {
  std::vector<float> result(points.size()), value;
  by_owner(points, [&](const BlockIndex& block, auto indices, const tree::Points& at) {
    value.resize(at.size());
    evaluations_ += at.size();
    field(block).values(at, value);
    for (std::size_t i = 0; i < at.size(); ++i) result[indices[i]] = value[i];
  });
  return result;
}

}  // namespace hoodoo::slice
