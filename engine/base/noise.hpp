#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/interval.hpp"
#include "engine/base/vector.hpp"

namespace hoodoo {

/// Turbulence t(p) = sum_{k=0}^{octaves-1} 2^-k n(2^k p / wavelength + o_k) / (2 - 2^(1-octaves)),
/// n simplex noise scaled and clamped to [0,1], o_k an offset per octave that depends on the seed.
/// Source: Paris et al. 2019, section 4.1; range and offsets as DESIGN section 3 mends them.
struct Turbulence {
  double wavelength = 10;  // [m], > 0
  int octaves = 3;         // 1 to 12
  std::uint32_t seed = 0;
};

/// One octave around an origin. A point's place in the simplex lattice is (i, j, k) + the place of
/// frequency * p + (x, y, z).
struct Octave {
  float frequency;  // [1/m]
  float x, y, z;    // what of the origin lies within its lattice cell
  std::uint32_t i, j, k, seed;
  float amplitude;  // of the normalised sum
};

/// A turbulence made ready for points relative to one origin.
struct PlacedTurbulence {
  static constexpr std::size_t most_octaves = 12;
  std::array<Octave, most_octaves> octaves;
  std::size_t count;
};

/// The lattice cell of the origin is taken in double, so that values keep their precision however
/// far it lies.
PlacedTurbulence placed(const Turbulence& t, const Vec3& origin);

/// Values of `t` in [0,1] at its origin + (x,y,z)[i] [m].
/// The same bits on every instruction set (no FMA, one lane = one point).
void turbulence(const PlacedTurbulence& t, std::span<const float> x, std::span<const float> y,
                std::span<const float> z, std::span<float> out);

/// As `turbulence`, with the gradient [1/m]. `out` has the same bits as from `turbulence`.
void turbulence_gradient(const PlacedTurbulence& t, std::span<const float> x,
                         std::span<const float> y, std::span<const float> z, std::span<float> out,
                         std::span<float> gx, std::span<float> gy, std::span<float> gz);

// The same, around `origin`.
inline void turbulence(const Turbulence& t, const Vec3& origin, std::span<const float> x,
                       std::span<const float> y, std::span<const float> z, std::span<float> out) {
  turbulence(placed(t, origin), x, y, z, out);
}
inline void turbulence_gradient(const Turbulence& t, const Vec3& origin, std::span<const float> x,
                                std::span<const float> y, std::span<const float> z,
                                std::span<float> out, std::span<float> gx, std::span<float> gy,
                                std::span<float> gz) {
  turbulence_gradient(placed(t, origin), x, y, z, out, gx, gy, gz);
}

/// A bound [1/m] on the length of the gradient of `t`.
double turbulence_slope(const Turbulence& t);

/// The value at one place.
inline double turbulence_at(const Turbulence& t, const Vec3& p) {
  const float zero = 0;
  float value = 0;
  turbulence(t, p, {&zero, 1}, {&zero, 1}, {&zero, 1}, {&value, 1});
  return static_cast<double>(value);
}

/// Contains the values at all points no farther than `reach` [m] from p, rounded outward.
inline Interval turbulence_bounds(const Turbulence& t, const Vec3& p, double reach) {
  const double change = turbulence_slope(t) * reach;
  if (!(change < 1)) return {0, 1};
  const double value = turbulence_at(t, p);
  return clamp(outward({value - change, value + change}), 0, 1);
}

}  // namespace hoodoo
