#pragma once
#include <span>
#include <vector>

#include "engine/generator/site.hpp"
#include "engine/generator/surface_samples.hpp"

namespace hoodoo::generator {

/// How open the input terrain lies at each sample, in [0, 1]: the radius of the largest ball that
/// touches it there from outside, over `most` [m]; 0 where there is no elevation.
/// Source: Miller 1994, tangent sphere accessibility.
std::vector<double> openness(const Site& site, std::span<const SurfaceSample> samples, double most);

}  // namespace hoodoo::generator
