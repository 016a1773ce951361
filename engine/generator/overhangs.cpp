#include "engine/generator/overhangs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/erosion.hpp"
#include "engine/generator/openness.hpp"
#include "engine/generator/placement.hpp"
#include "engine/generator/surroundings.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {
namespace {

/// What is drawn for an undercut, by number.
enum Draw : std::uint64_t { long_by = 1, high_by = 2, deep_by = 3, noise = 4 };
constexpr double step_radii = 0.75;  // between two places of the line, in radii
constexpr double row_radii = 0.9;    // between two rows of a lens
constexpr double rise_radii = 0.6;   // of the outermost row over the innermost
constexpr double smoothness = 0.25;  // of the join of rows
constexpr double away_radii = 0.5;   // before the face where nothing gives way
constexpr double deepest = 50;       // in heights

/// A place of a line along the face.
struct Place {
  Vec3 at, out;  // the level way out of the rock
  double along;  // from the middle, over the length to this side's end: in [-1, 1]
  double resistance;
};

/// An undercut to be.
struct Undercut {
  double length, height, depth;  // [m]
  double radius() const { return height / 2; }
};

struct Made {
  std::optional<tree::Node> lens;
  bool weak_roof = false, short_face = false;
};

/// Moves a place level, along the slope of F, onto the surface. None: there is no steep one near.
std::optional<Place> on_face(const Surroundings& near, Vec3 p, double reach, double level) {
  const Vec3 from = p;
  for (int i = 0; i < 6; ++i) {
    const auto value = near.at(p);
    const Vec3 slope{value.gradient.x, value.gradient.y, 0};
    const double off = 0.5 - static_cast<double>(value.field), steep = dot(slope, slope);
    if (!(steep > 0)) return std::nullopt;
    if (std::abs(off) < 0.02) {
      const Vec3 normal = normalized(-value.gradient);
      if (normal.z > level) return std::nullopt;
      return Place{p, outward(normal), 0, static_cast<double>(value.resistance)};
    }
    p = p + slope * (off / steep);
    const Vec3 moved = p - from;
    if (dot(moved, moved) > reach * reach) return std::nullopt;
  }
  return std::nullopt;
}

/// Follows the face from its middle to one side.
std::vector<Place> followed(const Surroundings& near, const Place& middle, double side, double half,
                            double step, double level) {
  std::vector<Place> line;
  Place last = middle;
  double gone = 0;
  while (gone + step <= half) {
    const Vec3 way = Vec3{-last.out.y, last.out.x, 0} * side;
    const auto next = on_face(near, last.at + way * step, step, level);
    if (!next || dot(next->out, last.out) < 0.2 || !near.covered(next->at)) break;
    gone += length(next->at - last.at);
    last = *next;
    last.along = side * gone;
    line.push_back(last);
  }
  for (auto& place : line) place.along /= gone + step;
  return line;
}

class Cutting {
 public:
  Cutting(const Overhangs& overhangs, const Growth& growth)
      : overhangs_(overhangs), growth_(growth), level_(bit_cos(overhangs.steepness * pi / 180)) {}

  double level() const { return level_; }

  Made cut(const SurfaceSample& sample, double stress) const {
    const auto key = key_of_place(growth_.seed, sample.at);
    const auto varied = [&](Draw what) {
      return 1 + overhangs_.variation * (2 * unit_real(random_bits(key, what)) - 1);
    };
    const Undercut size{overhangs_.length * varied(long_by), overhangs_.height * varied(high_by),
                        overhangs_.depth * varied(deep_by)};
    const Surroundings near(growth_.site,
                            Box{sample.at, sample.at}.grown(size.length / 2 + 3 * size.height));
    Made made;
    const Vec3 out = outward(sample.normal);
    const Vec3 over = sample.at + Vec3{0, 0, size.height} - out * size.radius();
    if (static_cast<double>(near.at(over).resistance) < overhangs_.roof) {
      made.weak_roof = true;
      return made;
    }
    const auto line = face(near, {sample.at, out, 0, static_cast<double>(sample.resistance)}, size);
    made.short_face = line.size() < 3;
    if (!made.short_face) made.lens = lens(line, size, stress, random_bits(key, noise));
    return made;
  }

 private:
  std::vector<Place> face(const Surroundings& near, const Place& middle,
                          const Undercut& size) const {
    const double step = step_radii * size.radius(), half = size.length / 2;
    auto line = followed(near, middle, -1, half, step, level_);
    std::ranges::reverse(line);
    line.push_back(middle);
    const auto right = followed(near, middle, 1, half, step, level_);
    line.insert(line.end(), right.begin(), right.end());
    return line;
  }

  /// Rows of tubes, one behind the other; where nothing gives way they lie before the face.
  tree::Node lens(const std::vector<Place>& line, const Undercut& size, double stress,
                  std::uint64_t key) const {
    const double r = size.radius();
    std::vector<double> depth;
    for (const auto& place : line) {
      const double left = 1 - place.along * place.along;
      depth.push_back(size.depth * left * growth_.weight(place.at) *
                      erosion_effect(place.resistance, stress, overhangs_.beta));
    }
    const double most = *std::ranges::max_element(depth);
    const int rows = std::max(1, static_cast<int>(std::ceil(most / (row_radii * r))));
    std::vector<tree::Node> tubes;
    for (int k = 1; k <= rows; ++k) {
      const double share = static_cast<double>(k) / rows;
      const double rise = rows > 1 ? rise_radii * r * (rows - k) / (rows - 1) : 0;
      tree::Polyline tube;
      tube.radius = r;
      tube.turbulence = overhangs_.turbulence;
      tube.turbulence.seed =
          static_cast<std::uint32_t>(random_bits(key, overhangs_.turbulence.seed));
      for (std::size_t i = 0; i < line.size(); ++i) {
        const double away = most > 0 ? 1 - depth[i] / most : 1;
        const double inward = share * depth[i] - r * (1 + away_radii * away);
        tube.points.emplace_back(line[i].at - line[i].out * inward + Vec3{0, 0, rise});
      }
      tubes.push_back({std::move(tube), {}});
    }
    if (tubes.size() == 1) return std::move(tubes.front());
    tree::SmoothUnion join;
    join.width = smoothness;
    return {join, std::move(tubes)};
  }

  const Overhangs& overhangs_;
  const Growth& growth_;
  double level_;  // upward part of the normal of a face that is just steep enough
};

}  // namespace

void Overhangs::check(const std::string& where, std::vector<Problem>& problems) const {
  if (depth > deepest * height) {
    problems.push_back({where + "/depth", fmt::format("must be at most 50 times \"height\", {} m, "
                                                      "got {}",
                                                      deepest * height, depth)});
  }
  tree::Thin tube;
  tube.radius = height / 2 * (1 - variation);
  tube.turbulence = turbulence;
  tube.check(where, problems);
}

void Overhangs::grow(Growth& growth) const {
  const Cutting cutting(*this, growth);
  const auto samples = sample_surface(
      growth.site, {growth.reach(), distance, random_bits(growth.seed, 0), cutting.level()});
  const auto open = generator::openness(growth.site, samples, this->openness);
  std::vector<std::size_t> middles;
  auto& marks = growth.record.list("middles");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& sample = samples[i];
    const double effect = erosion_effect(static_cast<double>(sample.resistance), open[i], beta) *
                          growth.weight(sample.at);
    marks.push_back({sample.at, effect});
    if (effect > 0 && effect >= threshold) middles.push_back(i);
  }
  std::vector<Made> made(middles.size());
  growth.site.in_parallel(middles.size(), [&](std::size_t n) {
    made[n] = cutting.cut(samples[middles[n]], open[middles[n]]);
  });
  std::vector<tree::Node> lenses;
  std::size_t weak_roofs = 0, short_faces = 0;
  for (auto& one : made) {
    weak_roofs += one.weak_roof ? 1 : 0;
    short_faces += one.short_face ? 1 : 0;
    if (one.lens) lenses.push_back(*std::move(one.lens));
  }
  growth.record.count("sampled", samples.size());
  growth.record.count("too weak", samples.size() - middles.size());
  growth.record.count("under a weak roof", weak_roofs);
  growth.record.count("on a short face", short_faces);
  growth.record.count("placed", lenses.size());
  expect_few(lenses.size(), most_primitives / 100, "undercuts");
  if (!lenses.empty()) growth.add(tree::Operation::difference, united(std::move(lenses)));
}

}  // namespace hoodoo::generator
