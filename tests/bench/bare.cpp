#include "tests/bench/bare.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/bare.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/noise-inl.hpp"

#ifndef HOODOO_BENCH_BARE_ROWS
#define HOODOO_BENCH_BARE_ROWS
namespace hoodoo::bench {

/// Points of one axis of a block within `reach` of `at`.
struct Range {
  int first, last;
};
inline Range within(float at, float reach, int low) {
  const auto l = static_cast<float>(low);
  return {std::max(0, static_cast<int>(std::ceil(at - reach - l))),
          std::min(side - 1, static_cast<int>(std::floor(at + reach - l)))};
}

}  // namespace hoodoo::bench
#endif

HWY_BEFORE_NAMESPACE();
namespace hoodoo::HWY_NAMESPACE {
using bench::Ball;
using bench::BlockCorner;
using bench::Rough;
using bench::side;

constexpr int row_points = side;

/// Calls use(dy, dz, row) for the rows of a block that a ball of radius `reach` touches.
template <class Use>
HWY_INLINE void ForRows(const Ball& ball, float reach, const BlockCorner& b, Use use) {
  const bench::Range planes = bench::within(ball.z, reach, b[2]);
  for (int k = planes.first; k <= planes.last; ++k) {
    const float dz = static_cast<float>(b[2] + k) - ball.z, rest = reach * reach - dz * dz;
    if (rest <= 0) continue;
    const bench::Range rows = bench::within(ball.y, std::sqrt(rest), b[1]);
    for (int j = rows.first; j <= rows.last; ++j) {
      use(static_cast<float>(b[1] + j) - ball.y, dz, k * side + j);
    }
  }
}

HWY_INLINE Floats Held(Floats v) {
  const Tag d;
  return hn::Min(hn::Max(v, hn::Zero(d)), hn::Set(d, 1.0F));
}

HWY_INLINE void Ground(const bench::Scene& scene, const BlockCorner& b, float* out) {
  const Tag d;
  const Floats half = hn::Set(d, 0.5F), scale = hn::Set(d, 1 / bench::ground_falloff);
  for (int k = 0; k < side; ++k) {
    const Floats z = hn::Set(d, static_cast<float>(b[2] + k));
    for (int j = 0; j < side; ++j) {
      const float* h = &scene.heights[static_cast<std::size_t>((b[1] + j - scene.low) * scene.wide +
                                                               b[0] - scene.low)];
      for (std::size_t i = 0; i < row_points; i += hn::Lanes(d)) {
        const Floats u = hn::Mul(hn::Sub(hn::LoadU(d, h + i), z), scale);
        const Floats c = hn::Min(hn::Max(u, hn::Set(d, -1.0F)), hn::Set(d, 1.0F));
        const Floats s = hn::Mul(c, hn::Sub(hn::Set(d, 1.5F), hn::Mul(half, hn::Mul(c, c))));
        hn::StoreU(hn::Add(half, hn::Mul(half, s)), d, out + (k * side + j) * side + i);
      }
    }
  }
}

HWY_INLINE void HoldAll(float* out) {
  const Tag d;
  for (std::size_t i = 0; i < bench::points_per_block; i += hn::Lanes(d)) {
    hn::StoreU(Held(hn::LoadU(d, out + i)), d, out + i);
  }
}

void Splat(const bench::Scene& scene, const bench::Bins& bins, const BlockCorner& b, float* out) {
  const Tag d;
  const Floats count = hn::Iota(d, 0.0F);  // goes through memory
  Ground(scene, b, out);
  for (const auto index : bins.of(b)) {
    const Ball& ball = scene.balls[index];
    const float per_square = 1 / (ball.reach * ball.reach);
    float across[row_points];
    for (std::size_t i = 0; i < row_points; i += hn::Lanes(d)) {
      const Floats dx =
          hn::Sub(hn::Add(count, hn::Set(d, static_cast<float>(b[0]) + static_cast<float>(i))),
                  hn::Set(d, ball.x));
      hn::StoreU(hn::Mul(hn::Mul(dx, dx), hn::Set(d, per_square)), d, across + i);
    }
    ForRows(ball, ball.reach, b, [&](float dy, float dz, int row) HWY_ATTR {
      const Floats rest = hn::Set(d, 1 - (dy * dy + dz * dz) * per_square);
      for (std::size_t i = 0; i < row_points; i += hn::Lanes(d)) {
        const Floats q = hn::Max(hn::Sub(rest, hn::LoadU(d, across + i)), hn::Zero(d));
        float* o = out + row * side + i;
        const Floats f = hn::Mul(hn::Mul(q, q), hn::Mul(q, hn::Set(d, ball.energy)));
        hn::StoreU(hn::Add(hn::LoadU(d, o), f), d, o);
      }
    });
  }
  HoldAll(out);
}

void RoughSplat(const bench::Scene& scene, const bench::Bins& bins, const Rough& rough,
                const PlacedTurbulence& noise, const BlockCorner& b, float* out) {
  const Tag d;
  const Floats count = hn::Iota(d, 0.0F);  // goes through memory
  Ground(scene, b, out);
  const Floats amplitude = hn::Set(d, rough.amplitude), one = hn::Set(d, 1.0F);
  for (const auto index : bins.of(b)) {
    const Ball& ball = scene.balls[index];
    const float reach = ball.reach + rough.amplitude;
    const float sx = ball.x - static_cast<float>(b[0]), sy = ball.y - static_cast<float>(b[1]),
                sz = ball.z - static_cast<float>(b[2]);
    ForRows(ball, reach, b, [&](float dy, float dz, int row) HWY_ATTR {
      const Floats rest = hn::Set(d, dy * dy + dz * dz);
      for (std::size_t i = 0; i < row_points; i += hn::Lanes(d)) {
        const Floats dx =
            hn::Sub(hn::Add(count, hn::Set(d, static_cast<float>(i))), hn::Set(d, sx));
        const Floats r2 = hn::Add(hn::Mul(dx, dx), rest);
        if (hn::AllFalse(d, hn::Lt(r2, hn::Set(d, reach * reach)))) continue;
        const Floats r = hn::Sqrt(r2);
        const Floats f =
            hn::Div(hn::Set(d, ball.reach * rough.thickness), hn::Max(r, hn::Set(d, 1e-12F)));
        const Floats t = SumOctaves<false>(noise.octaves.data(), noise.count,
                                           hn::Add(hn::Set(d, sx), hn::Mul(f, dx)),
                                           hn::Add(hn::Set(d, sy), hn::Mul(f, hn::Set(d, dy))),
                                           hn::Add(hn::Set(d, sz), hn::Mul(f, hn::Set(d, dz))))
                             .value;
        const Floats bump = hn::Mul(amplitude, hn::Sub(hn::Add(t, t), one));
        const Floats ratio = hn::Div(r, hn::Add(hn::Set(d, ball.reach), bump));
        const Floats q = hn::Max(hn::Sub(one, hn::Mul(ratio, ratio)), hn::Zero(d));
        float* o = out + row * side + i;
        const Floats v = hn::Mul(hn::Mul(q, q), hn::Mul(q, hn::Set(d, ball.energy)));
        hn::StoreU(hn::Add(hn::LoadU(d, o), v), d, o);
      }
    });
  }
  HoldAll(out);
}

void EveryPoint(const PlacedTurbulence& noise, float* out) {
  const Tag d;
  const Floats count = hn::Iota(d, 0.0F);
  for (int k = 0; k < side; ++k) {
    const Floats z = hn::Set(d, static_cast<float>(k));
    for (int j = 0; j < side; ++j) {
      const Floats y = hn::Set(d, static_cast<float>(j));
      for (std::size_t i = 0; i < row_points; i += hn::Lanes(d)) {
        const Noise t = SumOctaves<false>(noise.octaves.data(), noise.count,
                                          hn::Add(count, hn::Set(d, static_cast<float>(i))), y, z);
        hn::StoreU(t.value, d, out + (k * side + j) * side + i);
      }
    }
  }
}

}  // namespace hoodoo::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo {
HWY_EXPORT(Splat);
HWY_EXPORT(RoughSplat);
HWY_EXPORT(EveryPoint);
}  // namespace hoodoo

namespace hoodoo::bench {
namespace {

Vec3 corner(const BlockCorner& b) {
  return {static_cast<double>(b[0]), static_cast<double>(b[1]), static_cast<double>(b[2])};
}

}  // namespace

Bins::Bins(const Scene& scene, float grow) : scene_(scene) {
  const int n = scene.wide / side;
  bins_.resize(static_cast<std::size_t>(n * n));
  for (std::size_t i = 0; i < scene.balls.size(); ++i) {
    const Ball& b = scene.balls[i];
    const auto bin = [&](float v) {
      return static_cast<int>(std::floor((v - static_cast<float>(scene.low)) / side));
    };
    const float reach = b.reach + grow;
    for (int y = std::max(0, bin(b.y - reach)); y <= std::min(n - 1, bin(b.y + reach)); ++y) {
      for (int x = std::max(0, bin(b.x - reach)); x <= std::min(n - 1, bin(b.x + reach)); ++x) {
        bins_[static_cast<std::size_t>(y * n + x)].push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
}

std::span<const std::uint32_t> Bins::of(const BlockCorner& b) const {
  const int n = scene_.wide / side;
  return bins_[static_cast<std::size_t>((b[1] - scene_.low) / side * n +
                                        (b[0] - scene_.low) / side)];
}

void look_up(Scene& scene, const BlockCorner& b) {
  for (int y = b[1]; y < b[1] + side; ++y) {
    for (int x = b[0]; x < b[0] + side; ++x) {
      scene.heights[static_cast<std::size_t>((y - scene.low) * scene.wide + x - scene.low)] =
          static_cast<float>(scene.window.height(x, y));
    }
  }
}
void bare_splat(const Scene& scene, const Bins& bins, const BlockCorner& b, float* out) {
  HWY_DYNAMIC_DISPATCH(Splat)(scene, bins, b, out);
}
void bare_rough_splat(const Scene& scene, const Bins& bins, const Rough& rough,
                      const BlockCorner& b, float* out) {
  HWY_DYNAMIC_DISPATCH(RoughSplat)
  (scene, bins, rough, placed(rough.turbulence, corner(b)), b, out);
}
void bare_turbulence(const Turbulence& t, const BlockCorner& b, float* out) {
  HWY_DYNAMIC_DISPATCH(EveryPoint)(placed(t, corner(b)), out);
}

}  // namespace hoodoo::bench
#endif
