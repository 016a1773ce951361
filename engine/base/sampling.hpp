#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"

namespace hoodoo {

/// Maximal Poisson-disk sampling by the sum rule: no two samples lie closer than the sum of their
/// radii, and there is no room for another one.
///
/// The samples are a function of these fields on the whole plane. Regions cut them out: how the
/// plane is cut, in which order and by how many threads, changes no bit of them.
///
/// Limits: where the allowed part of the plane is thinner than radius_least / 4 samples may be
/// missing. What room is left was missed by darts into boxes narrower than radius_least / 100: of
/// 10^6 darts into the ground none finds any. It may be more where the radius is steeper than
/// `slope`.
struct PoissonDisk {
  std::uint64_t seed = 0;
  double radius_least = 1, radius_most = 1;  // [m], 0 < radius_least <= radius_most
  /// Half of the exclusion distance [m] at a point, in [radius_least, radius_most]; <= 0: no sample
  /// there. Empty: radius_least everywhere. Called from the calling thread only.
  std::function<double(double x, double y)> radius;
  double slope = 1;  // [1] bound on the change of `radius` per metre
  /// False only where no point of the box may have a sample; it spares searching there. x and y of
  /// the box count. Never changes the samples.
  std::function<bool(const Box&)> may_hold;
};
struct DiskSample {
  double x, y, radius;  // [m]
  std::uint64_t id;     // by seed and place; the same however the plane is cut
  friend bool operator==(const DiskSample&, const DiskSample&) = default;
};

/// All samples with min <= centre < max (x and y of `region` count), by x, then y.
///
/// Source: cells are halved where room is left, and darts are thrown into what remains: White,
/// Cline, Egbert 2007, Poisson disk point sets by hierarchical dart throwing; Ebeida et al. 2012, A
/// simple algorithm for maximal Poisson-disk sampling in high dimensions.
std::vector<DiskSample> poisson_disk(const PoissonDisk& disks, const Box& region);

/// The same in space: a volume, or a shell around a surface. There `may_hold` decides whether empty
/// space costs time.
struct PoissonSphere {
  std::uint64_t seed = 0;
  double radius_least = 1, radius_most = 1;
  std::function<double(double x, double y, double z)> radius;
  double slope = 1;
  std::function<bool(const Box&)> may_hold;
};
struct SphereSample {
  Vec3 center;
  double radius;
  std::uint64_t id;
  friend bool operator==(const SphereSample&, const SphereSample&) = default;
};

/// All samples with min <= centre < max, by x, then y, then z.
std::vector<SphereSample> poisson_sphere(const PoissonSphere& spheres, const Box& region);

/// The same in a shell under a height field, top - thickness <= z <= top, which may be thinner than
/// a sphere: far faster, as no dart falls beside it.
struct PoissonShell {
  std::uint64_t seed = 0;
  double radius_least = 1, radius_most = 1;
  std::function<double(double x, double y, double z)> radius;
  double slope = 1;
  double thickness = 1;                           // [m], > 0
  std::function<double(double x, double y)> top;  // [m]; NaN where there is no shell
  /// Between which `top` lies over x and y of a box [m]; low > high where there is none. How tight
  /// it is decides what time is spent beside the shell, and which samples are drawn.
  std::function<Interval(const Box&)> tops;
};

/// All samples with min <= centre < max (x and y of `region` count), by x, then y, then z.
///
/// Source: as of `poisson_disk`. Columns are halved in the plane; of each the heights are kept
/// between which samples leave room.
std::vector<SphereSample> poisson_shell(const PoissonShell& shell, const Box& region);

}  // namespace hoodoo
