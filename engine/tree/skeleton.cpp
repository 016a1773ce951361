#include "engine/tree/skeleton.hpp"

#include <fmt/format.h>

#include "engine/tree/nodes/points.hpp"

namespace hoodoo::tree {
namespace {

Support support_around(const Box& skeleton, double reach, double energy, double slope) {
  const double size = length(skeleton.max - skeleton.min);
  // Single precision may carry the field a little further.
  const double slack = 1e-5 * (reach + size);
  return {skeleton.grown(reach + slack), zero_to(energy), slope};
}

double slope_of(const Skeletal& s, double reach) {
  return s.turbulence.amplitude > 0 ? Support::no_bound
                                    : std::abs(s.energy) * steepest_falloff / reach;
}

}  // namespace

Support Thin::support_of(const Box& skeleton) const {
  return support_around(skeleton, reach() + turbulence.amplitude, energy, slope_of(*this, reach()));
}

void Thin::check(const std::string& where, std::vector<Problem>& problems) const {
  if (turbulence.amplitude >= reach()) {
    problems.push_back({where + "/turbulence/amplitude",
                        fmt::format("must be below radius / 0.4542 = {:.6g} m, got {}", reach(),
                                    turbulence.amplitude)});
  }
}

void PointSet::check(const std::string& where, std::vector<Problem>& problems) const {
  check_source(*this, where, problems);
  double least = Box::infinity;
  balls.for_each([&](const Balls::Stored& b) { least = std::min(least, b.radius); });
  check_least(least, where, problems);
}

void PointSet::check_least(double least_radius, const std::string& where,
                           std::vector<Problem>& problems) const {
  const double least = reach(least_radius);
  if (turbulence.amplitude >= least) {
    problems.push_back({where + "/turbulence/amplitude",
                        fmt::format("must be below the least radius / 0.4542 = {:.6g} m, got {}",
                                    least, turbulence.amplitude)});
  }
}

Support Volume::support_of(const Box& solid) const {
  return support_around(solid, falloff * (1 - half_falloff) + turbulence.amplitude, energy,
                        slope_of(*this, falloff));
}

}  // namespace hoodoo::tree
