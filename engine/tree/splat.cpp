#include "engine/tree/splat.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

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
void SmoothCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at, float* out,
                std::uint8_t* asked) {
  const Tag d;
  ForBallRows<thin, false>(
      balls, rule, at, [&](const SplatBall& ball, const CubeRows& rows) HWY_ATTR {
        const Lanes b(ball, rule);
        for (std::size_t row = 0; row < rows.n; ++row) {
          const Floats square = All(rows.square[row]);
          float* o = out + Cube::side * rows.place[row];
          asked[rows.place[row]] = 1;
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
void RoughCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at, float* out,
               std::uint8_t* asked) {
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
          asked[place] = 1;
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

/// Lists those of balls `first` to `last` whose field can differ from 0 at one of the sixteen
/// points from i on.
template <bool thin>
HWY_INLINE std::size_t FindNear(const SplatBalls& balls, std::size_t first, std::size_t last,
                                const SplatRule& rule, const Batch& p, std::size_t i,
                                std::uint32_t* near) {
  const Tag d;
  const WordTag dw;
  const Extent x(p.x + i, Cube::side), y(p.y + i, Cube::side), z(p.z + i, Cube::side);
  const auto square = [&](const Extent& e, Floats at) HWY_ATTR {
    const Floats below = hn::Sub(All(e.low), at), above = hn::Sub(at, All(e.high));
    const Floats gap = NotBelowZero(hn::Max(below, above));
    return hn::Mul(gap, gap);
  };
  Lanes b(balls[0], rule);
  Words index = hn::Add(hn::Iota(dw, 0U), hn::Set(dw, static_cast<std::uint32_t>(first)));
  const Words step = hn::Set(dw, static_cast<std::uint32_t>(Width()));
  std::size_t n = 0;
  for (std::size_t k = first; k < last; k += Width(), index = hn::Add(index, step)) {
    b.radius = hn::LoadU(d, balls.radius.data() + k);
    b.per_square = hn::LoadU(d, balls.per_square.data() + k);
    const Floats r2 = hn::Add(hn::Add(square(x, hn::LoadU(d, balls.x.data() + k)),
                                      square(y, hn::LoadU(d, balls.y.data() + k))),
                              square(z, hn::LoadU(d, balls.z.data() + k)));
    const auto live = hn::Gt(Closeness<thin, false>(r2, b, b.amplitude), hn::Zero(d));
    hn::StoreU(hn::Compress(index, hn::RebindMask(dw, live)), dw, near + n);
    n += hn::CountTrue(d, live);
  }
  return n;
}

/// Adds the fields of n balls to the vector of points at i.
template <bool thin, bool gradient>
HWY_INLINE void AddSmooth(const SplatBalls& balls, const SplatRule& rule, const std::uint32_t* near,
                          std::size_t n, Batch& p, std::size_t i) {
  const Tag d;
  const Floats x = hn::Load(d, p.x + i), y = hn::Load(d, p.y + i), z = hn::Load(d, p.z + i);
  Floats f = hn::Load(d, p.f + i), gx = hn::Load(d, p.gx + i), gy = hn::Load(d, p.gy + i),
         gz = hn::Load(d, p.gz + i);
  for (std::size_t k = 0; k < n; ++k) {
    const Lanes b(balls[near[k]], rule);
    const Floats dx = hn::Sub(x, b.x), dy = hn::Sub(y, b.y), dz = hn::Sub(z, b.z);
    const Floats r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    const Floats q = Closeness<thin, false>(r2, b, b.amplitude);
    f = hn::Add(f, Term(q, b));
    if constexpr (gradient) {
      const Floats steepest = hn::Mul(hn::Mul(All(-6.0F), b.energy), b.per_square);
      Floats steep = hn::Mul(steepest, hn::Mul(q, q));
      if constexpr (!thin) {
        const Floats r = hn::Sqrt(r2);
        const Floats u = NotBelowZero(hn::Add(hn::Sub(r, b.radius), b.inset));
        steep = hn::Mul(steep, hn::Div(u, hn::Max(All(1e-12F), r)));
      }
      gx = hn::Add(gx, hn::Mul(steep, dx));
      gy = hn::Add(gy, hn::Mul(steep, dy));
      gz = hn::Add(gz, hn::Mul(steep, dz));
    }
  }
  hn::Store(f, d, p.f + i);
  if constexpr (gradient) {
    hn::Store(gx, d, p.gx + i);
    hn::Store(gy, d, p.gy + i);
    hn::Store(gz, d, p.gz + i);
  }
}

/// Sixteen points after the other, each with the balls near them.
template <bool thin, bool gradient>
HWY_INLINE void SumSmooth(const SplatBalls& balls, const SplatRule& rule, Batch& p) {
  constexpr std::size_t most = 512;
  HWY_ALIGN std::uint32_t near[most + SplatBalls::wide];
  const std::size_t count = balls.list().size();
  for (std::size_t first = 0; first < count; first += most) {
    const std::size_t last = std::min(count, first + most);
    for (std::size_t i = 0; i < p.n; i += Cube::side) {
      const std::size_t n = FindNear<thin>(balls, first, last, rule, p, i, near);
      for (std::size_t k = i; k < i + Cube::side; k += Width()) {
        AddSmooth<thin, gradient>(balls, rule, near, n, p, k);
      }
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

/// The balls whose field can differ from 0 somewhere in the batch.
template <bool thin, bool gradient>
HWY_INLINE void SumRough(const SplatBalls& balls, const SplatRule& rule, Batch& p) {
  const Tag d;
  const Extent x(p.x, p.n), y(p.y, p.n), z(p.z, p.n);
  Candidates c;
  for (const SplatBall& ball : balls.list()) {
    const float gx = x.gap(ball.x), gy = y.gap(ball.y), gz = z.gap(ball.z);
    const Lanes b(ball, rule);
    const Floats q = Closeness<thin, true>(All(gx * gx + gy * gy + gz * gz), b, b.amplitude);
    if (!hn::AllFalse(d, hn::Gt(q, hn::Zero(d)))) AddRoughBatch<thin, gradient>(p, c, rule, b);
  }
}

template <bool thin, bool gradient>
void SumBatch(const SplatBalls& balls, const SplatRule& rule, Batch& p) {
  rule.amplitude > 0 ? SumRough<thin, gradient>(balls, rule, p)
                     : SumSmooth<thin, gradient>(balls, rule, p);
}

void SplatCube(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at, float* out,
               std::uint8_t* asked) {
  std::fill(out, out + Cube::size, 0.0F);
  if (balls.empty()) return;
  if (rule.amplitude > 0) {
    rule.thin ? RoughCube<true>(balls, rule, at, out, asked)
              : RoughCube<false>(balls, rule, at, out, asked);
  } else {
    rule.thin ? SmoothCube<true>(balls, rule, at, out, asked)
              : SmoothCube<false>(balls, rule, at, out, asked);
  }
}
void SplatValues(const SplatBalls& balls, const SplatRule& rule, Batch& p) {
  rule.thin ? SumBatch<true, false>(balls, rule, p) : SumBatch<false, false>(balls, rule, p);
}
void SplatGradients(const SplatBalls& balls, const SplatRule& rule, Batch& p) {
  rule.thin ? SumBatch<true, true>(balls, rule, p) : SumBatch<false, true>(balls, rule, p);
}

}  // namespace hoodoo::tree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::tree {

HWY_EXPORT(SplatCube);
HWY_EXPORT(SplatValues);
HWY_EXPORT(SplatGradients);

SplatBalls::SplatBalls(std::vector<SplatBall> list) : list_(std::move(list)) {
  constexpr float nowhere = 1e15F;
  const std::size_t n = (list_.size() + wide - 1) / wide * wide;
  for (auto* all : {&x, &y, &z}) all->assign(n, nowhere);
  radius.assign(n, 0);
  per_square.assign(n, 1);
  for (std::size_t i = 0; i < list_.size(); ++i) {
    x[i] = list_[i].x;
    y[i] = list_[i].y;
    z[i] = list_[i].z;
    radius[i] = list_[i].radius;
    per_square[i] = list_[i].per_square;
  }
}

void splat(const SplatBalls& balls, const SplatRule& rule, const Cube& at, CubeValues out,
           std::span<std::uint8_t, Cube::side * Cube::side> asked) {
  HWY_DYNAMIC_DISPATCH(SplatCube)(balls.list(), rule, at, out.data(), asked.data());
}
void splat(const SplatBalls& balls, const SplatRule& rule, const Points& at, std::span<float> out) {
  if (at.size() == 0) return;
  Batch batch(at);
  HWY_DYNAMIC_DISPATCH(SplatValues)(balls, rule, batch);
  batch.put(out);
}
void splat(const SplatBalls& balls, const SplatRule& rule, const Points& at, std::span<float> out,
           const Gradients& g) {
  if (at.size() == 0) return;
  Batch batch(at);
  HWY_DYNAMIC_DISPATCH(SplatGradients)(balls, rule, batch);
  batch.put(out);
  batch.put(g);
}

}  // namespace hoodoo::tree
#endif
