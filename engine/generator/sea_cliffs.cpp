#include "engine/generator/sea_cliffs.hpp"

#include <algorithm>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/openness.hpp"

namespace hoodoo::generator {
namespace {

/// 1 at sea level, 0 at `range` from it.
double wave_strength(double z, const SeaCliffs& sea) {
  const double d = (z - sea.sea_level) / sea.range;
  const double left = std::max(1 - d * d, 0.0);
  return left * left * left;
}

}  // namespace

void SeaCliffs::grow(Growth& growth) const {
  Box box = growth.reach();
  box.min.z = std::max(box.min.z, sea_level - range);
  box.max.z = std::min(box.max.z, sea_level + range);
  const double flat = bit_cos(steepness * pi / 180);  // upward part of the normals of beaches
  for (int step = 0; step < steps; ++step) {
    const auto samples =
        sample_surface(growth.site, {box, distance, random_bits(growth.seed, step), flat});
    const auto open = generator::openness(growth.site, samples, this->openness);
    std::vector<Stressed> stressed;
    stressed.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      stressed.push_back({samples[i], wave_strength(samples[i].at.z, *this) * open[i]});
    }
    erode(*this, stressed, growth);
  }
}

}  // namespace hoodoo::generator
