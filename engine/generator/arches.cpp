#include "engine/generator/arches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/erosion.hpp"
#include "engine/generator/near_points.hpp"
#include "engine/generator/placement.hpp"
#include "engine/generator/surface_samples.hpp"
#include "engine/generator/surroundings.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {
namespace {

/// What is drawn for an arch, by number.
enum Draw : std::uint64_t { chance = 1, within_region = 2, wide_by = 3, high_by = 4, noise = 5 };
constexpr std::array<double, 5> sides = {0, -15, 15, -30, 30};  // looked to [deg]
constexpr double row_radii = 0.7;     // between two rows of an opening, in radii
constexpr double narrowest = 0.75;    // the uppermost row, as a share of the lowest
constexpr double corner_radii = 0.5;  // of the tubes in the corners of the floor
constexpr double smoothness = 0.25;   // of the join of rows
constexpr double pier_spans = 0.8;    // from the middle to rock beside the opening
constexpr double most_steps = 400;    // through a wall

enum class Verdict { thick, low, no_piers, unlikely, wall };

/// A wall that an arch may be carved through.
struct Wall {
  Verdict verdict = Verdict::thick;
  Vec3 middle;
  Vec3 through;                         // level, at length 1
  double thickness = 0;                 // [m]
  double floor = 0, top = 0, span = 0;  // of the opening [m]
  double effect = 0;
  std::uint64_t key = 0;
};

class Looking {
 public:
  Looking(const Arches& arches, const Site& site, std::uint64_t seed)
      : arches_(arches),
        site_(site),
        seed_(seed),
        step_(std::max(site.spacing() / 2, arches.width / most_steps)) {}

  Wall wall(const SurfaceSample& sample) const {
    Wall made;
    made.key = key_of_place(seed_, sample.at);
    const double high = arches_.height * varied(made.key, high_by);
    made.span = arches_.span * varied(made.key, wide_by);
    const Surroundings near = around(sample.at, high, made.span);
    if (!find(near, sample, made)) return made;
    const double stress = 1 - made.thickness * made.thickness / (arches_.width * arches_.width);
    const auto rho = static_cast<double>(near.at(made.middle).resistance);
    made.effect = erosion_effect(rho, stress, arches_.beta);
    made.verdict = Verdict::unlikely;
    if (unit_real(random_bits(made.key, chance)) >= arches_.probability * made.effect) return made;
    made.verdict = fit(near, high, made);
    return made;
  }

  /// Rows of tubes one over the other, each from air to air, and one in either corner of the floor.
  tree::Node opening(const Wall& wall) const {
    const Surroundings near = around(wall.middle, wall.top - wall.floor, wall.span);
    const double r = std::min(wall.span, wall.top - wall.floor) / 2;
    const double low = wall.floor + r, high = wall.top - narrowest * r;
    const int rows = 1 + std::max(0, static_cast<int>(std::ceil((high - low) / (row_radii * r))));
    const Vec3 along{-wall.through.y, wall.through.x, 0};
    std::vector<tree::Node> tubes;
    const auto add = [&](double z, double aside, double radius) {
      const Vec3 at = Vec3{wall.middle.x, wall.middle.y, z} + along * aside;
      tubes.push_back({tube(near, wall, at, radius), {}});
    };
    for (int k = 0; k < rows; ++k) {
      const double share = rows > 1 ? static_cast<double>(k) / (rows - 1) : 0;
      add(low + (high - low) * share, 0, r * (1 - (1 - narrowest) * share * share));
    }
    const double corner = corner_radii * r;
    for (const double side : {-1.0, 1.0}) add(wall.floor + corner, side * (r - corner), corner);
    tree::SmoothUnion join;
    join.width = smoothness;
    return {join, std::move(tubes)};
  }

 private:
  double varied(std::uint64_t key, Draw what) const {
    return 1 + arches_.variation * (2 * unit_real(random_bits(key, what)) - 1);
  }
  Surroundings around(const Vec3& p, double high, double wide) const {
    Box box = Box{p, p}.grown(1.5 * arches_.width + 2 * wide);
    box.min.z = p.z - 2 * high;
    box.max.z = p.z + 2 * high + 2 * arches_.roof;
    return {site_, box};
  }

  /// How far the rock goes on; the width where that is farther.
  double air(const Surroundings& near, const Vec3& from, const Vec3& way) const {
    double gone = 0;
    while (gone < arches_.width && near.solid(from + way * gone)) gone += step_;
    return std::min(gone, arches_.width);
  }

  tree::Segment tube(const Surroundings& near, const Wall& wall, const Vec3& at,
                     double radius) const {
    tree::Segment made;
    made.radius = radius;
    made.from = at - wall.through * (air(near, at, -wall.through) + radius / 2);
    made.to = at + wall.through * (air(near, at, wall.through) + radius / 2);
    made.turbulence = arches_.turbulence;
    made.turbulence.seed = static_cast<std::uint32_t>(
        random_bits(random_bits(wall.key, noise), arches_.turbulence.seed));
    return made;
  }

  /// The thinnest wall behind a face.
  bool find(const Surroundings& near, const SurfaceSample& sample, Wall& wall) const {
    const Vec3 in = -outward(sample.normal);
    wall.thickness = arches_.width;
    for (const double side : sides) {
      const double s = bit_sin(side * pi / 180), c = bit_cos(side * pi / 180);
      const Vec3 way{c * in.x - s * in.y, s * in.x + c * in.y, 0};
      const double gone = air(near, sample.at + way * step_, way) + step_;
      if (gone >= wall.thickness || !is_open(near, sample.at + way * gone, way, wall.span)) {
        continue;
      }
      wall.thickness = gone;
      wall.through = way;
      wall.middle = sample.at + way * (gone / 2);
    }
    return wall.thickness < arches_.width;
  }

  bool is_open(const Surroundings& near, const Vec3& from, const Vec3& way, double far) const {
    for (double gone = step_; gone < far; gone += step_) {
      const Vec3 p = from + way * gone;
      if (near.solid(p) || !near.covered(p)) return false;
    }
    return true;
  }

  /// Puts the opening between the ground and what must be left over it.
  Verdict fit(const Surroundings& near, double high, Wall& wall) const {
    const Vec3 along{-wall.through.y, wall.through.x, 0};
    double over = wall.middle.z + high + arches_.roof;
    for (const double side : {-0.5, 0.0, 0.5}) {
      Vec3 p = wall.middle + along * (side * wall.span);
      if (!near.solid(p)) return Verdict::no_piers;
      while (p.z < over && near.solid(p)) p.z += step_;
      over = std::min(over, p.z);
    }
    wall.floor = wall.middle.z - high / 2;
    for (const double side : {-1.0, 1.0}) {
      Vec3 p = wall.middle + wall.through * (side * (wall.thickness + wall.span) / 2);
      while (p.z > wall.floor && !near.solid(p)) p.z -= step_;
      wall.floor = std::max(wall.floor, p.z);
    }
    wall.top = std::min(wall.floor + high, over - arches_.roof);
    if (wall.top - wall.floor < high / 2) return Verdict::low;
    for (const double side : {-1.0, 1.0}) {
      const Vec3 pier = wall.middle + along * (side * pier_spans * wall.span);
      if (!near.solid({pier.x, pier.y, (wall.floor + wall.top) / 2})) return Verdict::no_piers;
    }
    return Verdict::wall;
  }

  const Arches& arches_;
  const Site& site_;
  std::uint64_t seed_;
  double step_;
};

/// Those that no other with a lesser hash is too near.
std::vector<Wall> apart(const std::vector<Wall>& walls, double distance) {
  NearPoints places(distance);
  for (const auto& wall : walls) places.add(wall.middle);
  std::vector<Wall> kept;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    bool first = true;
    places.visit(walls[i].middle, distance, [&](std::uint32_t other) {
      first = first && (other == i || walls[other].key > walls[i].key);
    });
    if (first) kept.push_back(walls[i]);
  }
  return kept;
}

}  // namespace

void Arches::check(const std::string& where, std::vector<Problem>& problems) const {
  tree::Thin tube;
  tube.radius = std::min(span, height / 2) / 2 * corner_radii * (1 - variation);
  tube.turbulence = turbulence;
  tube.check(where, problems);
}

void Arches::grow(Growth& growth) const {
  const Looking looking(*this, growth.site, growth.seed);
  SurfaceSampling sampling{growth.reach().grown(distance + width), span,
                           random_bits(growth.seed, 0), bit_cos(steepness * pi / 180)};
  const auto samples = sample_surface(growth.site, sampling);
  std::vector<Wall> looked(samples.size());
  growth.site.in_parallel(samples.size(),
                          [&](std::size_t i) { looked[i] = looking.wall(samples[i]); });
  auto& record = growth.record;
  record.count("sampled", samples.size());
  const auto verdict = [&](Verdict v) {
    return static_cast<std::uint64_t>(std::ranges::count(looked, v, &Wall::verdict));
  };
  record.count("too thick", verdict(Verdict::thick));
  record.count("by chance", verdict(Verdict::unlikely));
  record.count("too low", verdict(Verdict::low));
  record.count("without piers", verdict(Verdict::no_piers));
  auto& marks = record.list("walls");
  for (const auto& one : looked) {
    if (one.verdict != Verdict::thick) marks.push_back({one.middle, one.thickness});
  }
  std::erase_if(looked, [](const Wall& one) { return one.verdict != Verdict::wall; });
  auto walls = apart(looked, distance);
  record.count("crowded out", looked.size() - walls.size());
  record.count("outside the region", std::erase_if(walls, [&](const Wall& one) {
                 return unit_real(random_bits(one.key, within_region)) >= growth.weight(one.middle);
               }));
  record.count("placed", walls.size());
  expect_few(walls.size(), most_primitives / 100, "arches");
  std::vector<tree::Node> openings(walls.size());
  growth.site.in_parallel(walls.size(),
                          [&](std::size_t i) { openings[i] = looking.opening(walls[i]); });
  if (!openings.empty()) growth.add(tree::Operation::difference, united(std::move(openings)));
}

}  // namespace hoodoo::generator
