#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/generator/site.hpp"

namespace hoodoo::generator {

/// Where the plane is sampled.
struct DiskSampling {
  Box box;           // samples lie in it, x and y [m]
  double least = 1;  // the least distance between two samples anywhere [m]
  double most = 1;   // the greatest that `distance` gives [m]
  std::uint64_t seed = 0;
  /// The least distance at a place, in [least, most] [m]; none: `least` everywhere.
  std::function<double(double x, double y)> distance{};
  /// Whether a sample is asked for; those that are not keep others away all the same.
  std::function<bool(double x, double y, std::uint64_t key)> wanted{};
};

/// Samples in a square of the least distance, on average: nine tenths of what random packing has.
inline constexpr double samples_per_square = 0.628;

struct DiskSample {
  double x, y;        // [m]
  std::uint64_t key;  // its own, to draw from
};

/// Poisson-disk samples of the plane: two are no nearer than the mean of their distances, and few
/// places are farther than that from all. By cells, in the order of their rows.
///
/// The plane is cut into cells of a diagonal of `least`, so that a cell has one sample at most.
/// Each holds candidates by hash, in rounds; a candidate is a sample if none of an earlier round,
/// or of the same and a lesser hash, is one and too near. Candidates are judged only as far as that
/// is asked. So a sample is a function of the seed and the place alone.
std::vector<DiskSample> sample_disks(const Site& site, const DiskSampling& sampling);

}  // namespace hoodoo::generator
