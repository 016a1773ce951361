#include "engine/tree/splat.hpp"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/tree/splat.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/tree/splat-inl.hpp"

#ifndef HOODOO_TREE_SPLAT_BATCH
#define HOODOO_TREE_SPLAT_BATCH
namespace hoodoo::tree {

inline constexpr std::size_t most_points = 256;

/// A batch and its sums, filled up to whole vectors with copies of its last point.
struct Batch {
  alignas(64) float x[most_points], y[most_points], z[most_points];
  alignas(64) float f[most_points] = {}, gx[most_points] = {}, gy[most_points] = {},
                    gz[most_points] = {};
  std::size_t n;

  explicit Batch(const Points& at) : n((at.size() + Cube::side - 1) / Cube::side * Cube::side) {
    assert(at.size() <= most_points);
    const std::pair<float*, std::span<const float>> rows[] = {{x, at.x}, {y, at.y}, {z, at.z}};
    for (const auto& [to, from] : rows) {
      std::fill(std::copy(from.begin(), from.end(), to), to + n, from.back());
    }
  }
  void put(std::span<float> out) const { std::copy(f, f + out.size(), out.begin()); }
  void put(const Gradients& g) const {
    std::copy(gx, gx + g.x.size(), g.x.begin());
    std::copy(gy, gy + g.y.size(), g.y.begin());
    std::copy(gz, gz + g.z.size(), g.z.begin());
  }
};

/// Points at which a rough ball's field can differ from 0: what the noise is asked for at once.
struct Candidates {
  static constexpr std::size_t most = 512;
  static constexpr std::size_t room = most + Cube::side;  // the last vector may run over
  alignas(64) float square[room] = {}, dx[room] = {}, dy[room] = {}, dz[room] = {};
  alignas(64) float x[room] = {}, y[room] = {}, z[room] = {};
  alignas(64) float t[room] = {}, tx[room] = {}, ty[room] = {}, tz[room] = {};
  alignas(64) std::uint32_t index[room] = {};
  std::size_t n = 0;
};

}  // namespace hoodoo::tree
#endif

HWY_BEFORE_NAMESPACE();
namespace hoodoo::tree::HWY_NAMESPACE {

template <bool thin>
void SmoothCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at,
                float* out) {
  const Tag d;
  ForBallRows<thin, false>(
      balls, rule, at, [&](const SplatBall& ball, const CubeRows& rows) HWY_ATTR {
        const Lanes b(ball, rule);
        for (std::size_t row = 0; row < rows.n; ++row) {
          const Floats square = All(rows.square[row]);
          float* o = out + Cube::side * rows.place[row];
          for (std::size_t k = 0; k < Cube::side; k += Width()) {
            const Floats r2 = hn::Add(square, hn::Load(d, rows.z2 + k));
            const Floats f = Term(Closeness<thin, false>(r2, b, b.amplitude), b);
            hn::StoreU(hn::Add(hn::LoadU(d, o + k), f), d, o + k);
          }
        }
      });
}

/// Adds one vector of points at `index` and on to those where the field can differ from 0.
template <bool thin>
HWY_INLINE void Append(Candidates& c, Floats square, Floats dx, Floats dy, Floats dz, Words index,
                       const Lanes& b) {
  const Tag d;
  const Floats q = Closeness<thin, true>(square, b, b.amplitude);
  const auto live = hn::Gt(q, hn::Zero(d));
  const auto put = [&](Floats v, float* to)
                       HWY_ATTR { hn::StoreU(hn::Compress(v, live), d, to + c.n); };
  put(square, c.square);
  put(dx, c.dx);
  put(dy, c.dy);
  put(dz, c.dz);
  const WordTag dw;
  hn::StoreU(hn::Compress(index, hn::RebindMask(dw, live)), dw, c.index + c.n);
  c.n += hn::CountTrue(d, live);
}

/// Where the turbulence is taken: the projection on the unperturbed boundary.
HWY_INLINE Floats ToBoundary(Floats square, const Lanes& b) {
  return hn::Div(b.radius, hn::Max(All(1e-12F), hn::Sqrt(square)));
}

HWY_INLINE void Project(Candidates& c, const Lanes& b) {
  const Tag d;
  for (std::size_t i = 0; i < c.n; i += Width()) {
    const Floats f = ToBoundary(hn::Load(d, c.square + i), b);
    hn::Store(hn::Add(b.x, hn::Mul(f, hn::Load(d, c.dx + i))), d, c.x + i);
    hn::Store(hn::Add(b.y, hn::Mul(f, hn::Load(d, c.dy + i))), d, c.y + i);
    hn::Store(hn::Add(b.z, hn::Mul(f, hn::Load(d, c.dz + i))), d, c.z + i);
  }
}

HWY_INLINE Floats Bump(Floats t, const Lanes& b) {
  return hn::Mul(b.amplitude, hn::Sub(hn::Mul(All(2.0F), t), All(1.0F)));
}

/// Adds the values of all candidates to `out` and forgets them.
template <bool thin>
void AddRough(Candidates& c, const SplatRule& rule, const Lanes& b, float* out) {
  const Tag d;
  Project(c, b);
  const std::size_t n = c.n;
  turbulence(rule.noise, {c.x, n}, {c.y, n}, {c.z, n}, {c.t, n});
  for (std::size_t i = 0; i < n; i += Width()) {
    const Floats bump = Bump(hn::Load(d, c.t + i), b);
    hn::Store(Term(Closeness<thin, true>(hn::Load(d, c.square + i), b, bump), b), d, c.t + i);
  }
  for (std::size_t i = 0; i < n; ++i) out[c.index[i]] += c.t[i];
  c.n = 0;
}

/// As AddRough, with gradients: by the chain rule, t at the projection v = s + radius n, n = d /
/// |d|.
template <bool thin>
void AddRoughGradients(Candidates& c, const SplatRule& rule, const Lanes& b, Batch& to) {
  const Tag d;
  Project(c, b);
  const std::size_t n = c.n;
  turbulence_gradient(rule.noise, {c.x, n}, {c.y, n}, {c.z, n}, {c.t, n}, {c.tx, n}, {c.ty, n},
                      {c.tz, n});
  for (std::size_t i = 0; i < n; i += Width()) {
    const Floats square = hn::Load(d, c.square + i), r = hn::Sqrt(square);
    const Floats per_r = hn::Div(All(1.0F), hn::Max(All(1e-12F), r));
    const Floats nx = hn::Mul(hn::Load(d, c.dx + i), per_r),
                 ny = hn::Mul(hn::Load(d, c.dy + i), per_r),
                 nz = hn::Mul(hn::Load(d, c.dz + i), per_r);
    const Floats tx = hn::Load(d, c.tx + i), ty = hn::Load(d, c.ty + i), tz = hn::Load(d, c.tz + i);
    const Floats along = hn::Add(hn::Add(hn::Mul(nx, tx), hn::Mul(ny, ty)), hn::Mul(nz, tz));
    const Floats bump = Bump(hn::Load(d, c.t + i), b);
    const Floats q = Closeness<thin, true>(square, b, bump);
    Floats steep = hn::Mul(hn::Mul(All(-6.0F), b.energy), hn::Mul(q, q));
    Floats share = hn::Mul(hn::Mul(All(2.0F), b.amplitude), hn::Mul(b.radius, per_r));
    if constexpr (thin) {
      const Floats grown = hn::Add(b.reach, bump), least = hn::Mul(All(1e-6F), b.reach);
      const Floats per = hn::Div(All(1.0F), hn::Max(least, grown)), ratio = hn::Mul(r, per);
      steep = hn::Mul(steep, hn::Mul(ratio, per));
      share = hn::IfThenElseZero(hn::Ge(grown, least), hn::Mul(share, ratio));
    } else {
      const Floats u = NotBelowZero(hn::Add(hn::Sub(hn::Sub(r, b.radius), bump), b.inset));
      steep = hn::Mul(steep, hn::Mul(u, b.per_square));
    }
    const auto part = [&](Floats nv, Floats tv) HWY_ATTR {
      return hn::Mul(steep, hn::Sub(nv, hn::Mul(share, hn::Sub(tv, hn::Mul(nv, along)))));
    };
    hn::Store(part(nx, tx), d, c.tx + i);
    hn::Store(part(ny, ty), d, c.ty + i);
    hn::Store(part(nz, tz), d, c.tz + i);
    hn::Store(Term(q, b), d, c.t + i);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t k = c.index[i];
    to.f[k] += c.t[i];
    to.gx[k] += c.tx[i];
    to.gy[k] += c.ty[i];
    to.gz[k] += c.tz[i];
  }
  c.n = 0;
}

template <bool thin>
void RoughCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at,
               float* out) {
  const Tag d;
  Candidates c;
  const WordTag dw;
  const Words count = hn::Iota(dw, 0U);
  ForBallRows<thin, true>(
      balls, rule, at, [&](const SplatBall& ball, const CubeRows& rows) HWY_ATTR {
        const Lanes b(ball, rule);
        for (std::size_t row = 0; row < rows.n; ++row) {
          if (c.n + Cube::side > Candidates::most) AddRough<thin>(c, rule, b, out);
          const std::uint32_t place = rows.place[row];
          const Floats square = All(rows.square[row]);
          const Floats dx = All(at.x[place / Cube::side] - ball.x);
          const Floats dy = All(at.y[place % Cube::side] - ball.y);
          for (std::size_t k = 0; k < Cube::side; k += Width()) {
            const Floats dz = hn::Sub(hn::Load(d, at.z.data() + k), b.z);
            const auto index = static_cast<std::uint32_t>(Cube::side * place + k);
            Append<thin>(c, hn::Add(square, hn::Load(d, rows.z2 + k)), dx, dy, dz,
                         hn::Add(count, hn::Set(dw, index)), b);
          }
        }
        AddRough<thin>(c, rule, b, out);
      });
}

/// Smallest and largest of whole vectors of numbers.
struct Extent {
  float low, high;
  HWY_INLINE Extent(const float* v, std::size_t n) {
    const Tag d;
    Floats least = hn::Load(d, v), most = least;
    for (std::size_t i = Width(); i < n; i += Width()) {
      least = hn::Min(least, hn::Load(d, v + i));
      most = hn::Max(most, hn::Load(d, v + i));
    }
    low = hn::GetLane(hn::MinOfLanes(d, least));
    high = hn::GetLane(hn::MaxOfLanes(d, most));
  }
  /// How far `at` lies from it.
  HWY_INLINE float gap(float at) const { return std::max({0.0F, low - at, at - high}); }
};

template <bool thin, bool gradient>
HWY_INLINE void AddSmooth(Batch& p, const Lanes& b) {
  const Tag d;
  const Floats steepest = hn::Mul(hn::Mul(All(-6.0F), b.energy), b.per_square);
  for (std::size_t i = 0; i < p.n; i += Width()) {
    const Floats dx = hn::Sub(hn::Load(d, p.x + i), b.x), dy = hn::Sub(hn::Load(d, p.y + i), b.y),
                 dz = hn::Sub(hn::Load(d, p.z + i), b.z);
    const Floats r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    const Floats q = Closeness<thin, false>(r2, b, b.amplitude);
    hn::Store(hn::Add(hn::Load(d, p.f + i), Term(q, b)), d, p.f + i);
    if constexpr (gradient) {
      Floats steep = hn::Mul(steepest, hn::Mul(q, q));
      if constexpr (!thin) {
        const Floats r = hn::Sqrt(r2);
        const Floats u = NotBelowZero(hn::Add(hn::Sub(r, b.radius), b.inset));
        steep = hn::Mul(steep, hn::Div(u, hn::Max(All(1e-12F), r)));
      }
      hn::Store(hn::Add(hn::Load(d, p.gx + i), hn::Mul(steep, dx)), d, p.gx + i);
      hn::Store(hn::Add(hn::Load(d, p.gy + i), hn::Mul(steep, dy)), d, p.gy + i);
      hn::Store(hn::Add(hn::Load(d, p.gz + i), hn::Mul(steep, dz)), d, p.gz + i);
    }
  }
}

template <bool thin, bool gradient>
void AddRoughBatch(Batch& p, Candidates& c, const SplatRule& rule, const Lanes& b) {
  const Tag d;
  const WordTag dw;
  const Words count = hn::Iota(dw, 0U);
  for (std::size_t i = 0; i < p.n; i += Width()) {
    const Floats dx = hn::Sub(hn::Load(d, p.x + i), b.x), dy = hn::Sub(hn::Load(d, p.y + i), b.y),
                 dz = hn::Sub(hn::Load(d, p.z + i), b.z);
    const Floats r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    Append<thin>(c, r2, dx, dy, dz, hn::Add(count, hn::Set(dw, static_cast<std::uint32_t>(i))), b);
  }
  if constexpr (gradient) {
    AddRoughGradients<thin>(c, rule, b, p);
  } else {
    AddRough<thin>(c, rule, b, p.f);
  }
}

/// Calls add(lanes) for the balls whose field can differ from 0 somewhere in the batch.
template <bool thin, bool rough, class Add>
HWY_INLINE void ForBalls(std::span<const SplatBall> balls, const SplatRule& rule, const Batch& p,
                         Add add) {
  const Tag d;
  const Extent x(p.x, p.n), y(p.y, p.n), z(p.z, p.n);
  for (const SplatBall& ball : balls) {
    const float gx = x.gap(ball.x), gy = y.gap(ball.y), gz = z.gap(ball.z);
    const Lanes b(ball, rule);
    const Floats q = Closeness<thin, rough>(All(gx * gx + gy * gy + gz * gz), b, b.amplitude);
    if (!hn::AllFalse(d, hn::Gt(q, hn::Zero(d)))) add(b);
  }
}

template <bool thin, bool gradient>
void SumBatch(std::span<const SplatBall> balls, const SplatRule& rule, Batch& p) {
  if (rule.amplitude > 0) {
    Candidates c;
    ForBalls<thin, true>(balls, rule, p, [&](const Lanes& b) HWY_ATTR {
      AddRoughBatch<thin, gradient>(p, c, rule, b);
    });
  } else {
    ForBalls<thin, false>(balls, rule, p,
                          [&](const Lanes& b) HWY_ATTR { AddSmooth<thin, gradient>(p, b); });
  }
}

void SplatCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at,
               float* out) {
  std::fill(out, out + Cube::size, 0.0F);
  if (balls.empty()) return;
  if (rule.amplitude > 0) {
    rule.thin ? RoughCube<true>(balls, rule, at, out) : RoughCube<false>(balls, rule, at, out);
  } else {
    rule.thin ? SmoothCube<true>(balls, rule, at, out) : SmoothCube<false>(balls, rule, at, out);
  }
}
void SplatValues(std::span<const SplatBall> balls, const SplatRule& rule, Batch& p) {
  rule.thin ? SumBatch<true, false>(balls, rule, p) : SumBatch<false, false>(balls, rule, p);
}
void SplatGradients(std::span<const SplatBall> balls, const SplatRule& rule, Batch& p) {
  rule.thin ? SumBatch<true, true>(balls, rule, p) : SumBatch<false, true>(balls, rule, p);
}

}  // namespace hoodoo::tree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::tree {

HWY_EXPORT(SplatCube);
HWY_EXPORT(SplatValues);
HWY_EXPORT(SplatGradients);

void splat(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at,
           CubeValues out) {
  HWY_DYNAMIC_DISPATCH(SplatCube)(balls, rule, at, out.data());
}
void splat(std::span<const SplatBall> balls, const SplatRule& rule, const Points& at,
           std::span<float> out) {
  if (at.size() == 0) return;
  Batch batch(at);
  HWY_DYNAMIC_DISPATCH(SplatValues)(balls, rule, batch);
  batch.put(out);
}
void splat(std::span<const SplatBall> balls, const SplatRule& rule, const Points& at,
           std::span<float> out, const Gradients& g) {
  if (at.size() == 0) return;
  Batch batch(at);
  HWY_DYNAMIC_DISPATCH(SplatGradients)(balls, rule, batch);
  batch.put(out);
  batch.put(g);
}

}  // namespace hoodoo::tree
#endif
