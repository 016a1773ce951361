#include "engine/generator/percolation_karst.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/erosion.hpp"
#include "engine/generator/geology.hpp"
#include "engine/generator/surface_samples.hpp"
#include "engine/hydrology/hydrology.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/nodes/points.hpp"

namespace hoodoo::generator {
namespace {

/// Sinks of larger worlds are found on a coarser lattice, whatever memory there is.
constexpr double most_cells = 1 << 22;

/// Over the whole world, so that no region changes what counts as a depression.
void add_sinks(const PercolationKarst& karst, Growth& growth, std::vector<Vec3>& starts) {
  const Box& world = growth.site.extent();
  double pixel = growth.site.pixel();
  while ((world.max.x - world.min.x) * (world.max.y - world.min.y) > most_cells * pixel * pixel) {
    pixel *= 2;
  }
  const auto ground = growth.site.elevations(world, pixel, hydrology::bytes_per_cell);
  auto filled = ground.grid;
  hydrology::fill(filled);
  auto& marks = growth.record.list("sinks");
  for (const auto& sink : hydrology::sinks(ground.grid, filled)) {
    const Vec3 p{ground.x(sink.i), ground.y(sink.j), static_cast<double>(sink.elevation)};
    if (growth.weight(p) <= 0) continue;
    growth.record.count("sinks");
    if (sink.depth < karst.min_sink_depth || sink.area < karst.min_sink_area) {
      growth.record.count("small sinks");
      continue;
    }
    marks.push_back({p, sink.depth});
    starts.push_back(p);
  }
}

void add_cliffs(const PercolationKarst& karst, Growth& growth, std::vector<Vec3>& starts) {
  const double flat = bit_cos(karst.steepness * pi / 180);
  SurfaceSampling sampling{growth.reach(), karst.cliffs, random_bits(growth.seed, 1)};
  sampling.level = flat;
  for (const auto& sample : sample_surface(growth.site, sampling)) {
    if (growth.weight(sample.at) <= 0) continue;
    growth.record.count("places on cliffs");
    starts.push_back(sample.at);
  }
}

std::vector<Vec3> starts_of(const PercolationKarst& karst, Growth& growth) {
  std::vector<Vec3> starts;
  for (const auto& point : karst.seeds) starts.push_back(point.value);
  growth.record.count("seeds", starts.size());
  if (karst.sinks) add_sinks(karst, growth, starts);
  if (karst.cliffs > 0) add_cliffs(karst, growth, starts);
  return starts;
}

InvasionRules rules_of(const PercolationKarst& karst, std::uint64_t seed) {
  InvasionRules rules;
  rules.rho_0 = karst.rho_0;
  rules.epsilon = karst.epsilon;
  rules.directions = karst.directions;
  rules.upward = karst.upward;
  rules.step = karst.steps();
  rules.exclusion = karst.exclusions();
  rules.cover = karst.cover.value_or(2 * karst.radius);
  rules.depth = karst.depth;
  rules.length = karst.length;
  rules.count = karst.count;
  for (const auto& point : karst.resurgences) rules.resurgences.push_back(point.value);
  rules.pull = karst.pull;
  rules.seed = seed;
  return rules;
}

Invasion invade_site(const PercolationKarst& karst, const Growth& growth,
                     std::span<const Vec3> starts) {
  Geology geology(growth.site);
  Heights heights(growth.site);
  const Box& world = growth.site.extent();
  const InvadedRock rock{
      [&](std::span<const Vec3> at, std::span<float> out) { geology.resistances(at, out); },
      [&](const Vec3& p) {
        const bool inside = p.x >= world.min.x && p.x <= world.max.x && p.y >= world.min.y &&
                            p.y <= world.max.y && growth.weight(p) > 0;
        const auto ground = inside ? heights.at(p.x, p.y) : std::nullopt;
        return ground ? *ground - p.z : std::numeric_limits<double>::quiet_NaN();
      }};
  return invade(starts, rules_of(karst, growth.seed), rock, most_primitives);
}

/// A ball at every passage; and between it and the one before, so that none is a radius from the
/// next.
std::vector<tree::Ball> balls_of(const PercolationKarst& karst, const Growth& growth,
                                 const Invasion& invasion) {
  const auto energy = [&](const Vec3& p, float rho) {
    return static_cast<float>(karst.energy * growth.weight(p) *
                              erosion_effect(static_cast<double>(rho), karst.stress, karst.beta));
  };
  std::vector<tree::Ball> balls;
  for (const auto& passage : invasion.passages) {
    if (passage.parent != Passage::none) {
      const Vec3 from = invasion.passages[passage.parent].at, way = passage.at - from;
      const auto parts = std::ceil(length(way) / karst.radius * (1 - 1e-9));
      for (double k = 1; k < parts; ++k) {
        const Vec3 p = from + (k / parts) * way;
        balls.push_back({p, karst.radius, energy(p, passage.resistance)});
      }
    }
    balls.push_back({passage.at, karst.radius, energy(passage.at, passage.resistance)});
  }
  std::erase_if(balls, [](const tree::Ball& ball) { return ball.energy <= 0; });
  expect_few(balls.size(), most_primitives, "balls");
  return balls;
}

void note(const Invasion& invasion, std::size_t starts, Record& record) {
  record.count("starts", starts);
  for (const auto why : invasion.start_refusals) {
    record.count(fmt::format("starts {}", refusal_names[static_cast<std::size_t>(why)]));
  }
  record.count("candidates", invasion.candidates);
  for (std::size_t i = 0; i < refusal_names.size(); ++i) {
    record.count(refusal_names[i], invasion.refused[i]);
  }
  auto& edges = record.edges_of("nodes");
  for (std::uint32_t i = 0; i < invasion.passages.size(); ++i) {
    const auto& one = invasion.passages[i];
    const auto rho = static_cast<double>(one.resistance);
    record.list("nodes").push_back({one.at, rho});
    if (one.parent == Passage::none) {
      record.list("starts").push_back({one.at, rho});
    } else {
      edges.push_back({one.parent, i});
    }
  }
  for (const auto& [from, to] : invasion.joins) edges.push_back({from, to});
}

}  // namespace

void PercolationKarst::check(const std::string& where, std::vector<Problem>& problems) const {
  if (exclusions() >= 2 * steps()) {
    problems.push_back(
        {where + "/exclusion", fmt::format("must be below twice the step = {:.6g} m, got {:.6g}",
                                           2 * steps(), exclusions())});
  }
  tree::PointSet set;
  set.turbulence = turbulence;
  set.check_least(radius, where, problems);
}

void PercolationKarst::grow(Growth& growth) const {
  const auto starts = starts_of(*this, growth);
  const auto invasion = invade_site(*this, growth, starts);
  note(invasion, starts.size(), growth.record);
  const auto balls = balls_of(*this, growth, invasion);
  growth.record.count("placed", balls.size());
  if (balls.empty()) return;
  tree::PointSet set;
  set.balls = tree::Balls(balls);
  set.turbulence = turbulence;
  set.turbulence.seed = static_cast<std::uint32_t>(random_bits(growth.seed, turbulence.seed));
  growth.add(tree::Operation::carve, {std::move(set), {}});
}

}  // namespace hoodoo::generator
