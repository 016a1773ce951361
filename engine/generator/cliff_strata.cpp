#include "engine/generator/cliff_strata.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/disk_samples.hpp"
#include "engine/generator/near_points.hpp"
#include "engine/generator/surface_samples.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/skeleton.hpp"

namespace hoodoo::generator {
namespace {

constexpr double amount = 2;     // a: what F loses where fD is 1
constexpr double deepest = 0.9;  // of the way along which F goes from 1/2 to 1

/// Balls reach all samples around them, and twice as deep as is worn.
double reach_of(const CliffStrata& strata) {
  return std::max(2.5 * strata.distance, 2 * strata.depth + strata.distance);
}

/// 0 at the steepness, 1 at `falloff` more; by the upward part of the normal.
double steep_share(const CliffStrata& strata, double upward) {
  const double low = bit_cos(strata.steepness * pi / 180);
  const double high = bit_cos(std::min(strata.steepness + strata.falloff, 180.0) * pi / 180);
  if (!(low > high)) return upward < low ? 1 : 0;
  const double t = std::clamp((low - upward) / (low - high), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// What fD must be at the surface, whose slope of F is `steep` [1/m], so that the softest rock is
/// worn to `depth`: F rises by s(u) / 2 from there on, as that of a terrain, and a sheet of balls
/// of reach R has (1 - (depth / R)^2)^4 of its sum left at that depth.
double control(double depth, double steep, double reach) {
  const double worn = std::min(depth, deepest * 0.75 / steep), u = worn * steep / 0.75;
  const double left = 1 - worn * worn / (reach * reach);
  return (3 - u * u) * u / 4 / (amount * left * left * left * left);
}

/// Energies of balls of reach R that make their sum `wanted` at each of their centres, nearly; less
/// at the edge of a face, so that its rim is not cut off from both sides.
std::vector<double> shared(const std::vector<Vec3>& at, const std::vector<double>& wanted,
                           double reach, double distance) {
  const double sheet = samples_per_square * pi / 4 * (reach / distance) * (reach / distance);
  NearPoints places(reach);
  for (const auto& p : at) places.add(p);
  std::vector<double> energies(at.size());
  std::vector<std::uint32_t> near;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (wanted[i] <= 0) continue;
    near.clear();
    places.visit(at[i], reach, [&](std::uint32_t other) { near.push_back(other); });
    std::ranges::sort(near);  // so that the sum does not depend on samples farther away
    double sum = 0;
    for (const auto other : near) {
      const Vec3 d = at[other] - at[i];
      const double left = std::max(0.0, 1 - dot(d, d) / (reach * reach));
      sum += left * left * left;
    }
    energies[i] = wanted[i] / std::max(sum, sheet);
  }
  return energies;
}

}  // namespace

void CliffStrata::grow(Growth& growth) const {
  const double reach = reach_of(*this);
  const auto samples =
      sample_surface(growth.site, {growth.reach().grown(reach), distance,
                                   random_bits(growth.seed, 0), bit_cos(steepness * pi / 180)});
  std::vector<Vec3> at;
  for (const auto& sample : samples) at.push_back(sample.at);
  const auto values = growth.site.values(at);
  std::vector<double> wanted(at.size());
  std::size_t shallow = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double steep = length(values[i].gradient);
    wanted[i] = growth.weight(at[i]) * steep_share(*this, samples[i].normal.z) *
                (steep > 0 ? control(depth, steep, reach) : 0);
    shallow += wanted[i] > 0 && depth * steep / 0.75 > deepest ? 1 : 0;
  }
  const auto energies = shared(at, wanted, reach, distance);
  std::vector<tree::Ball> balls;
  auto& marks = growth.record.list("samples");
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (energies[i] <= 0) continue;
    marks.push_back({at[i], wanted[i]});
    balls.push_back({at[i], reach * tree::half_falloff, static_cast<float>(energies[i])});
  }
  growth.record.count("sampled", samples.size());
  growth.record.count("shallower than asked", shallow);
  growth.record.count("placed", balls.size());
  expect_few(balls.size(), most_primitives, "balls");
  if (balls.empty()) return;
  tree::PointSet where;
  where.balls = tree::Balls(balls);
  tree::Erosion erosion;
  erosion.amount = amount;
  growth.add(tree::Operation::blend,
             {erosion,
              {banded(growth.site.ground().geology, bands, random_bits(growth.seed, 1)),
               {std::move(where), {}}}});
}

}  // namespace hoodoo::generator
