#include "tiling/slice/land.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/random.hpp"

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
  }
  return *field;
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
    field(block).gradients(at, value, {gx, gy, gz});
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 out = normalized({-gx[i], -gy[i], -gz[i]});
      normals[indices[i]] = {static_cast<float>(out.x), static_cast<float>(out.y),
                             static_cast<float>(out.z)};
    }
  });
  return normals;
}

std::vector<Vec3> Land::steps_to_surface(std::span<const StepPoint> points) {
  std::vector<Vec3> steps(points.size());
  std::vector<float> value, gx, gy, gz;
  std::vector<double> px, py, h, hx, hy;
  const auto newton = [](double above, const Vec3& gradient) {
    const double squared = dot(gradient, gradient);
    return squared > 0 ? gradient * (-above / squared) : Vec3{};
  };
  by_owner(points, [&](const BlockIndex& block, auto indices, const tree::Points& at) {
    const auto n = at.size();
    if (const dem::Window* window = field(block).height_field()) {
      for (auto* all : {&px, &py, &h, &hx, &hy}) all->resize(n);
      for (std::size_t i = 0; i < n; ++i) {
        const Vec3 p = metres(points[indices[i]]);
        px[i] = p.x;
        py[i] = p.y;
      }
      window->at(px, py, {h, hx, hy});
      for (std::size_t i = 0; i < n; ++i) {
        const double z = metres(points[indices[i]]).z;
        steps[indices[i]] = newton(h[i] - z, {hx[i], hy[i], -1});
      }
      return;
    }
    value.resize(n), gx.resize(n), gy.resize(n), gz.resize(n);
    field(block).gradients(at, value, {gx, gy, gz});
    for (std::size_t i = 0; i < n; ++i) {
      steps[indices[i]] = newton(value[i] - 0.5, {gx[i], gy[i], gz[i]});
    }
  });
  return steps;
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
    field(block).values(at, value);
    for (std::size_t i = 0; i < at.size(); ++i) result[indices[i]] = value[i];
  });
  return result;
}

}  // namespace hoodoo::slice
