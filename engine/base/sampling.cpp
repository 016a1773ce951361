#include "engine/base/sampling.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>

#include "engine/base/sampler.hpp"

namespace hoodoo {
namespace sampling {
namespace {

/// The kinds of ground as one. The plane is space without height; a shell is sampled in columns:
/// its cells lie in the plane.
struct Plane {
  static constexpr bool flat = true, shell = false;
  const PoissonDisk& of;
  double radius(const Vec3& p) const { return of.radius(p.x, p.y); }
};
struct Space {
  static constexpr bool flat = false, shell = false;
  const PoissonSphere& of;
  double radius(const Vec3& p) const { return of.radius(p.x, p.y, p.z); }
};
struct Shell {
  static constexpr bool flat = true, shell = true;
  const PoissonShell& of;
  double radius(const Vec3& p) const { return of.radius(p.x, p.y, p.z); }
};

/// Samples of the cells that overlap the region.
template <class Ground>
std::vector<Sample> samples_of(const Ground& ground, const Box& region) {
  const double per_side = 1 / (2 * ground.of.radius_most);
  Sampler<Ground> sampler(ground);
  sampler.run(cell_at<Ground::flat>(region.min, per_side),
              cell_at<Ground::flat>(region.max, per_side));
  return sampler.samples();
}

}  // namespace
}  // namespace sampling

std::vector<DiskSample> poisson_disk(const PoissonDisk& disks, const Box& region) {
  assert(disks.radius_least > 0 && disks.radius_least <= disks.radius_most);
  std::vector<DiskSample> result;
  if (!(region.min.x < region.max.x && region.min.y < region.max.y)) return result;
  for (const auto& s : sampling::samples_of(sampling::Plane{disks}, region)) {
    const auto& c = s.center;
    if (c.x < region.min.x || c.x >= region.max.x || c.y < region.min.y || c.y >= region.max.y) {
      continue;
    }
    result.push_back({c.x, c.y, s.radius, s.id});
  }
  std::ranges::sort(result, {}, [](const DiskSample& s) { return std::tuple(s.x, s.y); });
  return result;
}

namespace {

std::vector<SphereSample> in_order(std::vector<SphereSample> samples) {
  std::ranges::sort(samples, {}, [](const SphereSample& s) {
    return std::tuple(s.center.x, s.center.y, s.center.z);
  });
  return samples;
}

}  // namespace

std::vector<SphereSample> poisson_sphere(const PoissonSphere& spheres, const Box& region) {
  assert(spheres.radius_least > 0 && spheres.radius_least <= spheres.radius_most);
  std::vector<SphereSample> result;
  if (!(region.min.x < region.max.x && region.min.y < region.max.y &&
        region.min.z < region.max.z)) {
    return result;
  }
  for (const auto& s : sampling::samples_of(sampling::Space{spheres}, region)) {
    const auto& c = s.center;
    if (!region.contains(c) || c.x == region.max.x || c.y == region.max.y || c.z == region.max.z) {
      continue;
    }
    result.push_back({c, s.radius, s.id});
  }
  return in_order(std::move(result));
}

std::vector<SphereSample> poisson_shell(const PoissonShell& shell, const Box& region) {
  assert(shell.radius_least > 0 && shell.radius_least <= shell.radius_most);
  assert(shell.thickness > 0 && shell.top && shell.tops);
  std::vector<SphereSample> result;
  if (!(region.min.x < region.max.x && region.min.y < region.max.y)) return result;
  for (const auto& s : sampling::samples_of(sampling::Shell{shell}, region)) {
    const auto& c = s.center;
    if (c.x < region.min.x || c.x >= region.max.x || c.y < region.min.y || c.y >= region.max.y) {
      continue;
    }
    result.push_back({c, s.radius, s.id});
  }
  return in_order(std::move(result));
}

}  // namespace hoodoo
