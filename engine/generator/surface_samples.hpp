#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/generator/site.hpp"

namespace hoodoo::generator {

/// Where a surface is sampled.
struct SurfaceSampling {
  Box box;              // samples lie in it [m]
  double distance = 1;  // the least between two samples [m]
  std::uint64_t seed = 0;
  /// No sample where the normal's upward part is greater: ground that is too level. Nor where the
  /// cell's corners say that it is halfway from this to 1 or beyond, whatever is within the cell.
  double level = 1;
  std::function<bool(const Box&)> wanted{};   // of a column of blocks; none: every one
  std::function<bool(const Vec3&)> within{};  // of a place; none: every one
};

struct SurfaceSample {
  Vec3 at;
  Vec3 normal;  // out of the rock
  float resistance;
};

/// Poisson-sphere samples of the surface F = 1/2 of the scene so far, over its terrains: no two
/// nearer than `distance`, and hardly a place on the surface farther from all. In the order of
/// lattice cells.
///
/// Space is cut into cells of that size. A cell that the surface passes through holds candidates
/// by hash; they are taken round by round, and within one in 27 phases of cells that cannot reach
/// each other, wherever no sample is too near. So a sample depends on the cells around it alone,
/// not on the box, and not on threads.
std::vector<SurfaceSample> sample_surface(const Site& site, const SurfaceSampling& sampling);

}  // namespace hoodoo::generator
