#include "engine/generator/floating_islands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/disk_samples.hpp"
#include "engine/generator/erosion.hpp"
#include "engine/generator/geology.hpp"
#include "engine/generator/invasion.hpp"
#include "engine/generator/island.hpp"
#include "engine/generator/placement.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {
namespace {

/// What is drawn for an island, by number.
enum Draw : std::uint64_t { keep = 1, radius = 2, height = 3, shape = 4, cave = 5, layers = 6 };
constexpr double usual_distance = 2.2;  // between middles, in largest radii
constexpr int lattice = 32;             // the ground and an underside are looked at so finely
constexpr double cave_energy = 2, cave_beta = 0.1, cave_roughness = 0.3;

/// The highest ground under a circle. None: no ground, or the world ends.
std::optional<double> ground_under(const Site& site, const Vec3& middle, double radius) {
  const Vec3 wide{radius, radius, 0};
  const Box area{middle - wide, middle + wide};
  const Box& world = site.extent();
  if (area.min.x < world.min.x || area.max.x > world.max.x || area.min.y < world.min.y ||
      area.max.y > world.max.y) {
    return std::nullopt;
  }
  const auto ground = site.elevations(area, std::max(site.pixel(), 2 * radius / lattice));
  std::optional<double> highest;
  for (std::size_t cell = 0; cell < ground.grid.z.size(); ++cell) {
    const auto wide_by = static_cast<std::size_t>(ground.grid.width);
    const double x = ground.x(static_cast<std::int32_t>(cell % wide_by)) - middle.x;
    const double y = ground.y(static_cast<std::int32_t>(cell / wide_by)) - middle.y;
    const float z = ground.grid.z[cell];
    if (x * x + y * y > radius * radius) continue;
    if (!std::isnan(z)) {
      highest = std::max(highest.value_or(static_cast<double>(z)), static_cast<double>(z));
    }
  }
  return highest;
}

/// The lowest rock inside the outline.
double lowest(const Island& island) {
  const double r = island.size().radius;
  double least = island.middle().z - island.size().rim;
  for (int j = -lattice; j <= lattice; ++j) {
    for (int i = -lattice; i <= lattice; ++i) {
      const double x = island.middle().x + r * i / lattice, y = island.middle().y + r * j / lattice;
      if (island.inside(x, y) > 0) least = std::min(least, island.bottom(x, y));
    }
  }
  return least;
}

/// A place on the underside of an island, in a direction and so far out.
Vec3 on_underside(const Island& island, double angle, double share) {
  const Vec3 way{bit_cos(angle), bit_sin(angle), 0};
  double in = 0, out = island.size().radius;
  for (int i = 0; i < 24; ++i) {
    const double middle = (in + out) / 2;
    const Vec3 p = island.middle() + way * middle;
    (island.inside(p.x, p.y) > 0 ? in : out) = middle;
  }
  const Vec3 p = island.middle() + way * (share * in);
  return {p.x, p.y, island.bottom(p.x, p.y)};
}

class Making {
 public:
  Making(const FloatingIslands& islands, Growth& growth) : islands_(islands), growth_(growth) {}

  std::vector<Island> placed() const {
    const double apart = islands_.distance.value_or(usual_distance * islands_.most_radius);
    DiskSampling sampling{growth_.reach(), apart, apart, growth_.seed, {}, {}};
    sampling.wanted = [&](double, double, std::uint64_t key) {
      return unit_real(random_bits(key, keep)) < islands_.probability;
    };
    const auto samples = sample_disks(growth_.site, sampling);
    std::vector<std::optional<Island>> made(samples.size());
    growth_.site.in_parallel(samples.size(), [&](std::size_t i) { made[i] = island(samples[i]); });
    std::vector<Island> all;
    std::size_t outside = 0, homeless = 0;
    for (std::size_t i = 0; i < made.size(); ++i) {
      if (!made[i]) {
        ++homeless;
      } else if (unit_real(random_bits(samples[i].key, keep)) >=
                 islands_.probability * growth_.weight(made[i]->middle())) {
        ++outside;
      } else {
        all.push_back(*std::move(made[i]));
      }
    }
    growth_.record.count("sampled", samples.size());
    growth_.record.count("over the edge or a hole", homeless);
    growth_.record.count("outside the region", outside);
    growth_.record.count("placed", all.size());
    return all;
  }

  tree::Node worn(const Island& island, const tree::Node& rock) const {
    auto body = island.tree();
    const double u = std::min(islands_.erosion / island.size().falloff, 1.0);
    if (u == 0) return body;
    tree::Erosion erosion;
    erosion.amount = (3 - u * u) * u / 4;  // what F rises by on so much of a terrain's falloff
    return {erosion, {rock, island.around(), std::move(body)}};
  }

  std::vector<tree::Ball> cave_balls(const std::vector<Island>& all) const {
    Geology geology(growth_.site);
    std::vector<tree::Ball> balls;
    for (const auto& island : all) {
      std::vector<Vec3> starts;
      const auto key = key_of(island);
      for (int i = 0; i < islands_.caves; ++i) {
        starts.push_back(on_underside(island, 2 * pi * unit_real(random_bits(key, cave, i, 0)),
                                      0.4 + 0.5 * unit_real(random_bits(key, cave, i, 1))));
      }
      const InvadedRock rock{
          [&](std::span<const Vec3> at, std::span<float> out) { geology.resistances(at, out); },
          [&](const Vec3& p) {
            const double depth = island.depth(p);
            return depth > -islands_.cave_radius ? depth : std::numeric_limits<double>::quiet_NaN();
          }};
      const auto invasion = invade(starts, rules(key), rock, most_primitives);
      growth_.record.count("caves begun", starts.size() - invasion.start_refusals.size());
      for (const auto& passage : invasion.passages) {
        const double effect = erosion_effect(static_cast<double>(passage.resistance), 1, cave_beta);
        balls.push_back(
            {passage.at, islands_.cave_radius, static_cast<float>(cave_energy * effect)});
      }
    }
    return balls;
  }

 private:
  std::uint64_t key_of(const Island& island) const {
    return random_bits(growth_.seed, std::bit_cast<std::uint64_t>(island.middle().x),
                       std::bit_cast<std::uint64_t>(island.middle().y));
  }
  std::optional<Island> island(const DiskSample& sample) const {
    const auto between = [&](double low, double high, Draw what) {
      return low + (high - low) * unit_real(random_bits(sample.key, what));
    };
    const double r = between(islands_.least_radius, islands_.most_radius, radius);
    const auto ground = ground_under(growth_.site, {sample.x, sample.y, 0}, r);
    if (!ground) return std::nullopt;
    const Island::Size size{r, islands_.relief * r, islands_.rim * r, islands_.depth * r,
                            std::max(2 * growth_.site.spacing(), 1.25 * islands_.erosion)};
    const auto key = random_bits(sample.key, shape);
    const Island at_zero({sample.x, sample.y, 0}, size, key);
    const double air = between(islands_.least_height, islands_.most_height, height);
    return Island({sample.x, sample.y, *ground + air - lowest(at_zero)}, size, key);
  }
  InvasionRules rules(std::uint64_t key) const {
    InvasionRules rules;
    rules.rho_0 = islands_.rho_0;
    rules.upward = 1;
    rules.directions = 12;
    rules.step = 0.8 * islands_.cave_radius;
    rules.exclusion = rules.step;
    rules.cover = 1.5 * islands_.cave_radius;
    rules.depth = tree::longest;
    rules.length = tree::longest;
    rules.count = islands_.cave_length;
    rules.seed = random_bits(key, cave);
    return rules;
  }

  const FloatingIslands& islands_;
  Growth& growth_;
};

}  // namespace

void FloatingIslands::check(const std::string& where, std::vector<Problem>& problems) const {
  if (least_radius > most_radius) {
    problems.push_back(
        {where + "/least_radius",
         fmt::format("must be at most \"most_radius\", {} m, got {}", most_radius, least_radius)});
  }
  if (least_height > most_height) {
    problems.push_back(
        {where + "/least_height",
         fmt::format("must be at most \"most_height\", {} m, got {}", most_height, least_height)});
  }
}

void FloatingIslands::grow(Growth& growth) const {
  const Making making(*this, growth);
  const auto all = making.placed();
  expect_few(all.size(), most_primitives / 1000, "islands");
  if (all.empty()) return;
  auto& marks = growth.record.list("islands");
  const auto rock = banded(growth.site.ground().geology, bands, random_bits(growth.seed, layers));
  std::vector<tree::Node> bodies;
  for (const auto& island : all) {
    marks.push_back({island.middle(), island.size().radius});
    bodies.push_back(making.worn(island, rock));
  }
  growth.add(tree::Operation::unite, united(std::move(bodies)));
  const auto balls = making.cave_balls(all);
  growth.record.count("cave balls", balls.size());
  expect_few(balls.size(), most_primitives, "balls");
  if (balls.empty()) return;
  tree::PointSet set;
  set.balls = tree::Balls(balls);
  set.turbulence.amplitude = cave_roughness * cave_radius;
  set.turbulence.wavelength = 2 * cave_radius;
  set.turbulence.seed = static_cast<std::uint32_t>(random_bits(growth.seed, cave));
  growth.add(tree::Operation::carve, {std::move(set), {}});
}

}  // namespace hoodoo::generator
