#include "tiling/surface/lanes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/surface/lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tiling/surface/qef.hpp"

HWY_BEFORE_NAMESPACE();
namespace hoodoo::surface::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using Truth = hn::Mask<Tag>;
using FloatTag = hn::Rebind<float, Tag>;
using WholeTag = hn::Rebind<std::int32_t, Tag>;

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }
HWY_INLINE Doubles Load(const float* v) { return hn::PromoteTo(Tag(), hn::Load(FloatTag(), v)); }
HWY_INLINE Doubles Load(const std::int32_t* v) {
  return hn::PromoteTo(Tag(), hn::Load(WholeTag(), v));
}

/// As engine/base/vector.hpp, a vector per lane, its sums in the same order.
struct Vec {
  Doubles x, y, z;
};
HWY_INLINE Vec operator+(const Vec& a, const Vec& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec operator-(const Vec& a, const Vec& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec operator*(const Vec& a, Doubles s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}
HWY_INLINE Doubles Dot(const Vec& a, const Vec& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec Cross(const Vec& a, const Vec& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec Where(Truth m, const Vec& a, const Vec& b) {
  return {hn::IfThenElse(m, a.x, b.x), hn::IfThenElse(m, a.y, b.y), hn::IfThenElse(m, a.z, b.z)};
}
HWY_INLINE Vec LoadWhere(Truth m, const float (*v)[SheetLanes::most], std::size_t i) {
  return {hn::IfThenElseZero(m, Load(v[0] + i)), hn::IfThenElseZero(m, Load(v[1] + i)),
          hn::IfThenElseZero(m, Load(v[2] + i))};
}

/// As qef.cpp has it.
struct Symmetric {
  Doubles xx, yy, zz, xy, xz, yz;

  HWY_INLINE Vec operator*(const Vec& v) const {
    return {Dot({xx, xy, xz}, v), Dot({xy, yy, yz}, v), Dot({xz, yz, zz}, v)};
  }
  HWY_INLINE void add(const Vec& n) {
    xx = hn::Add(xx, hn::Mul(n.x, n.x));
    yy = hn::Add(yy, hn::Mul(n.y, n.y));
    zz = hn::Add(zz, hn::Mul(n.z, n.z));
    xy = hn::Add(xy, hn::Mul(n.x, n.y));
    xz = hn::Add(xz, hn::Mul(n.x, n.z));
    yz = hn::Add(yz, hn::Mul(n.y, n.z));
  }
  HWY_INLINE Doubles trace() const { return hn::Add(hn::Add(xx, yy), zz); }
};

/// rotate of qef.cpp in the lanes that are `open` and whose entry does not vanish already.
HWY_INLINE void Rotate(Truth open, Doubles& pp, Doubles& qq, Doubles& pq, Doubles& pr, Doubles& qr,
                       Vec& p, Vec& q) {
  const Truth turn = hn::And(open, hn::Ne(pq, All(0)));
  const Doubles one = All(1);
  const Doubles theta = hn::Div(hn::Sub(qq, pp), hn::Mul(All(2), pq));
  const Doubles root = hn::Sqrt(hn::Add(hn::Mul(theta, theta), one));
  const Doubles sign = hn::IfThenElse(hn::Ge(theta, All(0)), one, All(-1));
  const Doubles t = hn::Div(sign, hn::Add(hn::Abs(theta), root));
  const Doubles c = hn::Div(one, hn::Sqrt(hn::Add(hn::Mul(t, t), one))), s = hn::Mul(t, c);
  const auto put = [turn](Doubles& to, Doubles v) HWY_ATTR { to = hn::IfThenElse(turn, v, to); };
  put(pp, hn::Sub(pp, hn::Mul(t, pq)));
  put(qq, hn::Add(qq, hn::Mul(t, pq)));
  put(pq, All(0));
  const Doubles old_pr = pr;
  put(pr, hn::Sub(hn::Mul(c, pr), hn::Mul(s, qr)));
  put(qr, hn::Add(hn::Mul(s, old_pr), hn::Mul(c, qr)));
  const Vec old_p = p;
  p = Where(turn, p * c - q * s, p);
  q = Where(turn, old_p * s + q * c, q);
}

/// Pseudo-inverse of `m` times `b` by Jacobi's method; lanes that are not `open` are left as is.
HWY_INLINE Vec Solve(Symmetric m, const Vec& b, Truth open) {
  const Doubles one = All(1), zero = All(0);
  Vec x{one, zero, zero}, y{zero, one, zero}, z{zero, zero, one};
  const Doubles small = hn::Mul(hn::Mul(All(1e-20), m.trace()), m.trace());
  for (int sweep = 0; sweep < 8; ++sweep) {
    const Doubles off =
        hn::Add(hn::Add(hn::Mul(m.xy, m.xy), hn::Mul(m.xz, m.xz)), hn::Mul(m.yz, m.yz));
    open = hn::And(open, hn::Not(hn::Le(off, small)));
    if (hn::AllFalse(Tag(), open)) break;
    Rotate(open, m.xx, m.yy, m.xy, m.xz, m.yz, x, y);
    Rotate(open, m.xx, m.zz, m.xz, m.xy, m.yz, x, z);
    Rotate(open, m.yy, m.zz, m.yz, m.xy, m.xz, y, z);
  }
  const Doubles least = hn::Mul(All(least_eigenvalue), hn::Max(hn::Max(m.xx, m.yy), m.zz));
  Vec result{zero, zero, zero};
  const auto add = [&](Doubles value, const Vec& v) HWY_ATTR {
    result = Where(hn::Gt(value, least), result + v * hn::Div(Dot(v, b), value), result);
  };
  add(m.xx, x);
  add(m.yy, y);
  add(m.zz, z);
  return result;
}

HWY_INLINE void Snap(Doubles v, Doubles units, std::int32_t* to) {
  const Doubles one = All(1);
  const Doubles inside = hn::Min(hn::Max(v, All(0)), one);
  const Doubles step = hn::Floor(hn::Add(hn::Mul(inside, units), All(0.5)));
  const WholeTag dw;
  hn::Store(hn::DemoteTo(dw, hn::Min(hn::Max(step, one), hn::Sub(units, one))), dw, to);
}

HWY_INLINE void SolveSome(SheetLanes& sheets, std::size_t i, Doubles units) {
  const Tag d;
  const Doubles count = hn::Load(d, sheets.count + i), zero = All(0);
  std::size_t most = 0;
  while (most < SheetLanes::most_planes &&
         !hn::AllFalse(d, hn::Gt(count, All(static_cast<double>(most))))) {
    ++most;
  }
  const auto has = [&](std::size_t k)
                       HWY_ATTR { return hn::Gt(count, All(static_cast<double>(k))); };
  Vec mean{zero, zero, zero};
  for (std::size_t k = 0; k < most; ++k) mean = mean + LoadWhere(has(k), sheets.point[k], i);
  mean = mean * hn::Div(All(1), count);
  Symmetric m{zero, zero, zero, zero, zero, zero};
  Vec b{zero, zero, zero}, direction{zero, zero, zero};
  for (std::size_t k = 0; k < most; ++k) {
    const Vec point = LoadWhere(has(k), sheets.point[k], i);
    const Vec n = LoadWhere(has(k), sheets.normal[k], i);
    m.add(n);
    b = b + n * Dot(n, point - mean);
    direction = direction + n;
  }
  const Doubles squared = Dot(direction, direction), rayleigh = Dot(direction, m * direction);
  const Doubles rest = hn::Sub(hn::Mul(m.trace(), squared), rayleigh);
  const Truth one_counts =
      hn::And(hn::Gt(squared, zero), hn::Lt(rest, hn::Mul(All(least_eigenvalue), rayleigh)));
  const Vec v = m * (m * (m * direction));
  Vec best = v * hn::Div(Dot(v, b), Dot(v, m * v));
  const Truth others = hn::Not(one_counts);
  if (!hn::AllFalse(d, others)) best = Where(one_counts, best, Solve(m, b, others));
  best = mean + best;
  Snap(best.x, units, sheets.steps[0] + i);
  Snap(best.y, units, sheets.steps[1] + i);
  Snap(best.z, units, sheets.steps[2] + i);
  hn::Store(mean.x, d, sheets.mean[0] + i);
  hn::Store(mean.y, d, sheets.mean[1] + i);
  hn::Store(mean.z, d, sheets.mean[2] + i);
}

void SolveSheets(SheetLanes& sheets, std::size_t n, int units) {
  for (std::size_t i = n; i < SheetLanes::most; ++i) sheets.count[i] = 1;
  const Doubles per_cell = All(units);
  for (std::size_t i = 0; i < n; i += hn::Lanes(Tag())) SolveSome(sheets, i, per_cell);
}

HWY_INLINE Vec Corner(const QuadLanes& quads, std::size_t c, std::size_t i) {
  return {Load(quads.corner[c][0] + i), Load(quads.corner[c][1] + i), Load(quads.corner[c][2] + i)};
}

/// Of the triangles on both sides of a diagonal: whether both run about the axis, and how well the
/// worse agrees with the normal.
struct Sides {
  Truth valid;
  Doubles agreement;
};
template <int axis>
HWY_INLINE Sides Divide(const Vec& a, const Vec& b, const Vec& c, const Vec& e, Doubles sign,
                        const Vec& wanted) {
  const Vec diagonal = c - a;
  const Vec first = Cross(b - a, diagonal) * sign, second = Cross(diagonal, e - a) * sign;
  const auto along = [](const Vec& v) HWY_ATTR { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; };
  const auto agreement = [&](const Vec& v)
                             HWY_ATTR { return hn::Div(Dot(v, wanted), hn::Sqrt(Dot(v, v))); };
  const Doubles zero = All(0);
  return {hn::And(hn::Gt(hn::Mul(along(first), sign), zero),
                  hn::Gt(hn::Mul(along(second), sign), zero)),
          hn::Min(agreement(first), agreement(second))};
}

template <int axis>
HWY_INLINE void CutAll(QuadLanes& quads, std::size_t n) {
  const Tag d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Vec c0 = Corner(quads, 0, i), c1 = Corner(quads, 1, i), c2 = Corner(quads, 2, i),
              c3 = Corner(quads, 3, i);
    const Vec wanted{Load(quads.wanted[0] + i), Load(quads.wanted[1] + i),
                     Load(quads.wanted[2] + i)};
    const Doubles sign = Load(quads.sign + i);
    const Sides from_0 = Divide<axis>(c0, c1, c2, c3, sign, wanted);
    const Sides from_1 = Divide<axis>(c1, c2, c3, c0, sign, wanted);
    const Truth second =
        hn::Or(hn::Not(from_0.valid),
               hn::And(from_1.valid, hn::Not(hn::Ge(from_0.agreement, from_1.agreement))));
    const Doubles diagonal = hn::IfThenElseZero(second, All(1));
    hn::Store(hn::DemoteTo(WholeTag(), diagonal), WholeTag(), quads.diagonal + i);
  }
}

void CutQuads(QuadLanes& quads, std::size_t n, int axis) {
  axis == 0 ? CutAll<0>(quads, n) : axis == 1 ? CutAll<1>(quads, n) : CutAll<2>(quads, n);
}

}  // namespace hoodoo::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::surface {

HWY_EXPORT(SolveSheets);
HWY_EXPORT(CutQuads);

void solve(SheetLanes& sheets, std::size_t n, int units) {
  HWY_DYNAMIC_DISPATCH(SolveSheets)(sheets, n, units);
}
void cut(QuadLanes& quads, std::size_t n, int axis) {
  HWY_DYNAMIC_DISPATCH(CutQuads)(quads, n, axis);
}

}  // namespace hoodoo::surface
#endif
