#include "engine/base/noise.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine/base/random.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/base/noise.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/noise-inl.hpp"

#ifndef HOODOO_BASE_NOISE_ARRAYS
#define HOODOO_BASE_NOISE_ARRAYS
namespace hoodoo {

struct NoiseArrays {
  const float *x, *y, *z;
  float *out, *gx, *gy, *gz;
};

}  // namespace hoodoo
#endif

HWY_BEFORE_NAMESPACE();
namespace hoodoo {
namespace HWY_NAMESPACE {

template <bool gradient>
void Evaluate(const Octave* octaves, std::size_t count, const NoiseArrays& a, std::size_t n) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const Noise t = SumOctaves<gradient>(octaves, count, hn::LoadU(d, a.x + i),
                                         hn::LoadU(d, a.y + i), hn::LoadU(d, a.z + i));
    hn::StoreU(t.value, d, a.out + i);
    if constexpr (gradient) {
      hn::StoreU(t.gx, d, a.gx + i);
      hn::StoreU(t.gy, d, a.gy + i);
      hn::StoreU(t.gz, d, a.gz + i);
    }
  }
  if (i == n) return;
  // The rest goes through padded copies, by the same instructions.
  constexpr std::size_t most = HWY_MAX_BYTES / sizeof(float);
  float in[3][most] = {}, out[4][most];
  std::copy(a.x + i, a.x + n, in[0]);
  std::copy(a.y + i, a.y + n, in[1]);
  std::copy(a.z + i, a.z + n, in[2]);
  Evaluate<gradient>(octaves, count, {in[0], in[1], in[2], out[0], out[1], out[2], out[3]}, lanes);
  std::copy(out[0], out[0] + (n - i), a.out + i);
  if constexpr (gradient) {
    std::copy(out[1], out[1] + (n - i), a.gx + i);
    std::copy(out[2], out[2] + (n - i), a.gy + i);
    std::copy(out[3], out[3] + (n - i), a.gz + i);
  }
}

void Values(const Octave* octaves, std::size_t count, const NoiseArrays& a, std::size_t n) {
  Evaluate<false>(octaves, count, a, n);
}
void ValuesAndGradients(const Octave* octaves, std::size_t count, const NoiseArrays& a,
                        std::size_t n) {
  Evaluate<true>(octaves, count, a, n);
}

}  // namespace HWY_NAMESPACE
}  // namespace hoodoo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo {
namespace {

HWY_EXPORT(Values);
HWY_EXPORT(ValuesAndGradients);

// Bounds the slope of simplex noise (found by search, as its scale).
constexpr double simplex_slope = 7.03;

double normalisation(int octaves) { return 2 - std::ldexp(1.0, 1 - octaves); }

}  // namespace

PlacedTurbulence placed(const Turbulence& t, const Vec3& origin) {
  assert(t.wavelength > 0 && t.octaves >= 1 &&
         static_cast<std::size_t>(t.octaves) <= PlacedTurbulence::most_octaves);
  PlacedTurbulence all{};
  all.count = static_cast<std::size_t>(t.octaves);
  for (int o = 0; o < t.octaves; ++o) {
    // Single precision holds no more; so short a wave is nothing but 1/2.
    const double f = std::min(std::ldexp(1 / t.wavelength, o), 1e15);
    const auto offset = [&](int axis) { return 256 * unit_real(random_bits(t.seed, o, axis)); };
    const Vec3 p = origin * f + Vec3{offset(0), offset(1), offset(2)};
    const double skew = (p.x + p.y + p.z) / 3;
    const double i = std::floor(p.x + skew), j = std::floor(p.y + skew), k = std::floor(p.z + skew);
    const double back = (i + j + k) / 6;
    const auto word = [](double v) {
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::clamp(v, -9e18, 9e18)));
    };
    all.octaves[static_cast<std::size_t>(o)] = {
        static_cast<float>(f),
        static_cast<float>(p.x - (i - back)),
        static_cast<float>(p.y - (j - back)),
        static_cast<float>(p.z - (k - back)),
        word(i),
        word(j),
        word(k),
        static_cast<std::uint32_t>(random_bits(t.seed, o, 3)),
        static_cast<float>(std::ldexp(1 / normalisation(t.octaves), -o))};
  }
  return all;
}

void turbulence(const PlacedTurbulence& t, std::span<const float> x, std::span<const float> y,
                std::span<const float> z, std::span<float> out) {
  assert(x.size() == out.size() && y.size() == out.size() && z.size() == out.size());
  HWY_DYNAMIC_DISPATCH(Values)
  (t.octaves.data(), t.count,
   NoiseArrays{x.data(), y.data(), z.data(), out.data(), nullptr, nullptr, nullptr}, out.size());
}

void turbulence_gradient(const PlacedTurbulence& t, std::span<const float> x,
                         std::span<const float> y, std::span<const float> z, std::span<float> out,
                         std::span<float> gx, std::span<float> gy, std::span<float> gz) {
  assert(x.size() == out.size() && y.size() == out.size() && z.size() == out.size());
  HWY_DYNAMIC_DISPATCH(ValuesAndGradients)
  (t.octaves.data(), t.count,
   NoiseArrays{x.data(), y.data(), z.data(), out.data(), gx.data(), gy.data(), gz.data()},
   out.size());
}

double turbulence_slope(const Turbulence& t) {
  // Octave k has amplitude 2^-k and frequency 2^k: each adds the same slope. Half of [-1, 1]'s.
  return 0.5 * simplex_slope / t.wavelength * t.octaves / normalisation(t.octaves);
}

}  // namespace hoodoo
#endif
