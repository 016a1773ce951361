#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

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

/// Values of `t` in [0,1] at origin + (x,y,z)[i] [m]. The lattice cell of the origin is taken in
/// double, so the result keeps its precision however far the origin lies.
/// The same bits on every instruction set (no FMA, one lane = one point).
void turbulence(const Turbulence& t, const Vec3& origin, std::span<const float> x,
                std::span<const float> y, std::span<const float> z, std::span<float> out);

/// As `turbulence`, with the gradient [1/m]. `out` has the same bits as from `turbulence`.
void turbulence_gradient(const Turbulence& t, const Vec3& origin, std::span<const float> x,
                         std::span<const float> y, std::span<const float> z, std::span<float> out,
                         std::span<float> gx, std::span<float> gy, std::span<float> gz);

/// A bound [1/m] on the length of the gradient of `t`.
double turbulence_slope(const Turbulence& t);

}  // namespace hoodoo
