#pragma once
#include <cstdint>
#include <span>
#include <tuple>

#include "engine/generator/growth.hpp"
#include "engine/generator/surface_samples.hpp"
#include "engine/tree/fields.hpp"

namespace hoodoo::generator {

/// e(rho, sigma) = sigma (1 - rho)(1 - beta) + sigma beta: how much rock of resistance rho gives
/// way under stress sigma, all in [0, 1]. e(rho, 0) = 0 and e(1, 1) = beta.
/// Source: Paris et al. 2019, section 6.1.
constexpr double erosion_effect(double rho, double sigma, double beta) {
  return sigma * (1 - rho) * (1 - beta) + sigma * beta;
}

/// What every erosion does at its samples. Source: Paris et al. 2019, section 6.1.
struct Erosion {
  double radius = 4;    // of a ball [m]
  double distance = 2;  // the least between two samples [m]
  double energy = 2;    // of a ball where e = 1
  double beta = 0.1;
  double threshold = 0.05;  // least e
  std::uint32_t seed = 0;
};

template <class G>
constexpr auto erosion_fields() {
  using namespace tree;
  return std::tuple{
      Number<G>{"radius", &G::radius, "m", above(0, longest), 4.0,
                "Radius of the balls that are carved out at the samples."},
      Number<G>{"distance", &G::distance, "m", above(0, longest), 2.0,
                "Least distance between two samples."},
      Number<G>{"energy", &G::energy, "1", above(0, 100), 2.0,
                "Energy of a ball where the effect is 1; others have the effect's share of it."},
      Number<G>{"beta", &G::beta, "1", within(0, 1), 0.1,
                "Effect on the hardest rock where the stress is greatest: e = s (1 - rho)(1 - "
                "beta) + s beta."},
      Number<G>{"threshold", &G::threshold, "1", within(0, 1), 0.05,
                "Samples of a smaller effect are left out."},
      Whole<G, std::uint32_t>{"seed", &G::seed, 0, 4294967295LL, 0u, "Of the samples."}};
}

/// A sample and the stress on it, in [0, 1].
struct Stressed {
  SurfaceSample sample;
  double stress;
};

/// Carves a ball at every sample whose effect, times the region's weight, reaches the threshold;
/// counts what was sampled, too weak and placed.
void erode(const Erosion& erosion, std::span<const Stressed> samples, Growth& growth);

}  // namespace hoodoo::generator
