// Batch evaluation of the leaves that cover all space.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/tree/evaluate.hpp"
#include "engine/tree/nodes/plane.hpp"
#include "engine/tree/nodes/strata.hpp"

namespace hoodoo::tree {
namespace {

using Row = std::array<float, batch_size>;

Interval slope_bounds(double value, double slope, const Block& block, const Interval& range) {
  const double half = length(block.box.max - block.box.min) / 2;
  const Interval near = outward({value - slope * half, value + slope * half});
  return {std::max(near.low, range.low), std::min(near.high, range.high)};
}

Vec3 centre(const Block& block) { return (block.box.min + block.box.max) * 0.5; }

}  // namespace

void Strata::values(const Vec3& origin, const Points& at, std::span<float> out) const {
  const std::size_t n = at.size();
  const Row zero{};
  turbulence(noise(), {0, 0, origin.z}, {zero.data(), n}, {zero.data(), n}, at.z, out);
  const auto e = static_cast<float>(energy);
  for (float& v : out) v = v * e + 0.0F;
}

void Strata::gradients(const Vec3& origin, const Points& at, std::span<float> out,
                       const Gradients& g) const {
  const std::size_t n = at.size();
  const Row zero{};
  turbulence_gradient(noise(), {0, 0, origin.z}, {zero.data(), n}, {zero.data(), n}, at.z, out, g.x,
                      g.y, g.z);
  const auto e = static_cast<float>(energy);
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = out[i] * e + 0.0F;
    g.x[i] = 0;
    g.y[i] = 0;
    g.z[i] *= e;
  }
}

Interval Strata::bounds(const Block& block) const {
  const Support s = support({});
  const double z = centre(block).z;
  const Block column{block.origin, {{0, 0, block.box.min.z}, {0, 0, block.box.max.z}}};
  return slope_bounds(energy * turbulence_at(noise(), {0, 0, z}), s.slope, column, s.range);
}

Support Plane::support(std::span<const Support>) const {
  const Interval layer = zero_to(energy);
  const double layer_slope = std::abs(energy) * steepest_falloff / falloff;
  return {Box::everywhere(), layer + zero_to(amplitude),
          layer_slope + std::abs(amplitude) * turbulence_slope(noise())};
}

namespace {

/// The plane in numbers relative to a block.
struct LocalPlane {
  float nx, ny, nz, offset, per_square, energy, amplitude;

  LocalPlane(const Plane& plane, const Vec3& origin) {
    const Vec3 n = normalized(plane.normal);
    nx = static_cast<float>(n.x);
    ny = static_cast<float>(n.y);
    nz = static_cast<float>(n.z);
    offset = static_cast<float>(dot(n, origin - plane.point.value));
    per_square = static_cast<float>(inverse_square(plane.falloff));
    energy = static_cast<float>(plane.energy);
    amplitude = static_cast<float>(plane.amplitude);
  }
  template <class T>
  T layer(const T& x, const T& y, const T& z) const {
    const T d = x * nx + y * ny + z * nz + offset;
    return falloff_of_square(d * d, per_square, energy);
  }
};

}  // namespace

void Plane::values(const Vec3& origin, const Points& at, std::span<float> out) const {
  const LocalPlane local(*this, origin);
  for (std::size_t i = 0; i < at.size(); ++i) out[i] = local.layer(at.x[i], at.y[i], at.z[i]);
  if (amplitude == 0) return;
  Row t;
  turbulence(noise(), origin, at.x, at.y, at.z, {t.data(), at.size()});
  for (std::size_t i = 0; i < at.size(); ++i) out[i] += local.amplitude * t[i];
}

void Plane::gradients(const Vec3& origin, const Points& at, std::span<float> out,
                      const Gradients& g) const {
  const LocalPlane local(*this, origin);
  const std::size_t n = at.size();
  for (std::size_t i = 0; i < n; ++i) {
    using D = Dual<float>;
    const D f = local.layer(D(at.x[i], 1, 0, 0), D(at.y[i], 0, 1, 0), D(at.z[i], 0, 0, 1));
    out[i] = f.v;
    g.x[i] = f.x;
    g.y[i] = f.y;
    g.z[i] = f.z;
  }
  if (amplitude == 0) return;
  Row t, tx, ty, tz;
  turbulence_gradient(noise(), origin, at.x, at.y, at.z, {t.data(), n}, {tx.data(), n},
                      {ty.data(), n}, {tz.data(), n});
  for (std::size_t i = 0; i < n; ++i) {
    out[i] += local.amplitude * t[i];
    g.x[i] += local.amplitude * tx[i];
    g.y[i] += local.amplitude * ty[i];
    g.z[i] += local.amplitude * tz[i];
  }
}

Interval Plane::bounds(const Block& block) const {
  const Vec3 c = centre(block);
  const double half = length(block.box.max - block.box.min) / 2 + 1e-6 * length(c - block.origin);
  const double d = std::abs(dot(normalized(normal), c - point.value));
  const auto g = [&](double r) {
    const double q = std::max(0.0, 1 - r * r / (falloff * falloff));
    return q * q * q;
  };
  const Interval layer = Interval{g(d + half), g(std::max(0.0, d - half))} * energy;
  if (amplitude == 0) return outward(layer);
  const Interval noisy =
      slope_bounds(amplitude * turbulence_at(noise(), c),
                   std::abs(amplitude) * turbulence_slope(noise()), block, zero_to(amplitude));
  return outward(layer + noisy);
}

}  // namespace hoodoo::tree
