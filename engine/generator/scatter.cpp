#include "engine/generator/scatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/disk_samples.hpp"
#include "engine/generator/placement.hpp"

namespace hoodoo::generator {
namespace {

/// Share of the samples that grow where no distance is stated.
constexpr double usual_share = 2.0 / 3;
/// What is drawn for a copy, by number.
enum Draw : std::uint64_t { keep = 1, turning = 2, scaling = 3, lean = 4, side = 5, noise = 6 };

/// Rotations that take z to a direction: about z to its side, then down. Without an inverse
/// function of angles the lean is a turn about a horizontal axis, found by halving.
double angle_from_z(double cosine) {
  double low = 0, high = 180;
  for (int i = 0; i < 48; ++i) {
    const double middle = (low + high) / 2;
    (bit_cos(middle * (pi / 180)) > cosine ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

double Scatter::apart() const {
  return distance.value_or(std::sqrt(samples_per_square * usual_share / density));
}

void Scatter::check(const std::string& where, std::vector<Problem>& problems) const {
  if (least_scale > most_scale) {
    problems.push_back({where + "/least_scale", fmt::format("must be at most \"most_scale\", {}, "
                                                            "got {}",
                                                            most_scale, least_scale)});
  }
  const double most = samples_per_square / (apart() * apart());
  if (density > most) {
    problems.push_back(
        {where + "/density",
         fmt::format("must be at most {:.4g} 1/m^2, so that copies can lie {:.4g} m apart, got {}",
                     most, apart(), density)});
  }
}

void Scatter::read_trees(const std::string&, const ReadTree& read, std::vector<Problem>& problems) {
  auto made = read(stated.json, stated.where);
  if (!made) return;
  expect_movable(*made, stated.where, problems);
  tree = *std::move(made);
}

void Scatter::grow(Growth& growth) const {
  const Box box = growth.reach();
  if (!(box.min.x <= box.max.x && box.min.y <= box.max.y)) return;
  const HabitatMap map(growth.site, *this, box);
  const double share = density * apart() * apart() / samples_per_square;
  DiskSampling sampling{box, apart(), apart(), growth.seed, {}, {}};
  sampling.wanted = [&](double x, double y, std::uint64_t key) {
    return unit_real(random_bits(key, keep)) < share * map.suitability(x, y);
  };
  const auto samples = sample_disks(growth.site, sampling);
  std::vector<Vec3> at;
  for (const auto& s : samples) at.push_back({s.x, s.y, 0});
  const auto feet = footings(growth.site, at);
  growth.record.count("sampled", samples.size());
  auto& marks = growth.record.list("places");
  std::vector<tree::Node> copies;
  std::size_t lost = 0, outside = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& foot = feet[i];
    const auto key = samples[i].key;
    const auto draw = [&](Draw what) { return unit_real(random_bits(key, what)); };
    if (!foot.found) {
      ++lost;
      continue;
    }
    const double chance = share * map.suitability(foot.at.x, foot.at.y);
    if (draw(keep) >= chance * growth.weight(foot.at)) {
      ++outside;
      continue;
    }
    Placement placement{foot.at, {}, least_scale + (most_scale - least_scale) * draw(scaling)};
    Vec3 up{0, 0, 1};
    const Vec3& n = foot.normal;
    const Vec3 axis{-n.y, n.x, 0};
    if (align == Align::normal && dot(axis, axis) > 1e-12) {
      up = n;
      placement.turn({axis, angle_from_z(n.z)});
    }
    if (tilt > 0) {
      const double around = 2 * pi * draw(side);
      placement.turn({{bit_cos(around), bit_sin(around), 0}, tilt * draw(lean)});
    }
    placement.turn({{0, 0, 1}, turn * draw(turning)});
    placement.at = foot.at - up * (sink * placement.scale);
    copies.push_back(placed(tree, placement, random_bits(key, noise)));
    marks.push_back({foot.at, placement.scale});
  }
  if (lost > 0) growth.record.count("off the ground", lost);
  if (outside > 0) growth.record.count("outside the region", outside);
  growth.record.count("placed", copies.size());
  expect_few(copies.size() * tree::count(tree), most_primitives, "nodes");
  if (!copies.empty()) growth.add(op, united(std::move(copies)));
}

}  // namespace hoodoo::generator
