// Falloffs of balls for one vector of points, compiled once per Highway target.
#if defined(HOODOO_TREE_SPLAT_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HOODOO_TREE_SPLAT_INL_HPP
#undef HOODOO_TREE_SPLAT_INL_HPP
#else
#define HOODOO_TREE_SPLAT_INL_HPP
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "engine/tree/splat.hpp"

HWY_BEFORE_NAMESPACE();
namespace hoodoo::tree::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, Cube::side>;
using Floats = hn::Vec<Tag>;
using WordTag = hn::RebindToUnsigned<Tag>;
using Words = hn::Vec<WordTag>;

HWY_INLINE std::size_t Width() { return hn::Lanes(Tag()); }
HWY_INLINE Floats All(float v) { return hn::Set(Tag(), v); }

/// The larger of v and 0; 0 for what is no number.
HWY_INLINE Floats NotBelowZero(Floats v) { return hn::Max(v, hn::Zero(Tag())); }

/// One ball in every lane.
struct Lanes {
  Floats x, y, z, radius, reach, per_square, energy, inset, amplitude;
  HWY_INLINE Lanes(const SplatBall& b, const SplatRule& rule)
      : x(All(b.x)),
        y(All(b.y)),
        z(All(b.z)),
        radius(All(b.radius)),
        reach(All(b.reach)),
        per_square(All(b.per_square)),
        energy(All(b.energy)),
        inset(All(rule.inset)),
        amplitude(All(rule.amplitude)) {}
};

/// 1 - (r / R)^2, or 0, r^2 = `square`. What the turbulence moves the boundary by is `bump`, in a
/// rough field.
template <bool thin, bool rough>
HWY_INLINE Floats Closeness(Floats square, const Lanes& b, Floats bump) {
  const Floats one = All(1.0F);
  if constexpr (thin && !rough) {
    return NotBelowZero(hn::Sub(one, hn::Mul(square, b.per_square)));
  } else if constexpr (thin) {
    const Floats least = hn::Mul(All(1e-6F), b.reach);
    const Floats ratio = hn::Div(hn::Sqrt(square), hn::Max(least, hn::Add(b.reach, bump)));
    return NotBelowZero(hn::Sub(one, hn::Mul(ratio, ratio)));
  } else {
    Floats d = hn::Sub(hn::Sqrt(square), b.radius);
    if constexpr (rough) d = hn::Sub(d, bump);
    const Floats u = NotBelowZero(hn::Add(d, b.inset));
    return NotBelowZero(hn::Sub(one, hn::Mul(hn::Mul(u, u), b.per_square)));
  }
}

/// e q^3. It may be -0, which a sum that began with 0 does not feel.
HWY_INLINE Floats Term(Floats q, const Lanes& b) {
  return hn::Mul(hn::Mul(q, q), hn::Mul(q, b.energy));
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

/// Squares of the distances of sixteen coordinates from one.
HWY_INLINE void Squares(const float* at, Floats centre, float* squares) {
  const Tag d;
  for (std::size_t i = 0; i < Cube::side; i += Width()) {
    const Floats v = hn::Sub(hn::Load(d, at + i), centre);
    hn::Store(hn::Mul(v, v), d, squares + i);
  }
}

/// The rows of a cube that a ball reaches, at 16 i + j, and squares of distances: from each row's
/// line, and along it. They are listed before the field is found there, so that a ball costs one
/// branch that cannot be foreseen and not one per plane; and a ball ahead, so that what is stored
/// here has left the store buffer when it is read.
struct CubeRows {
  HWY_ALIGN float z2[Cube::side];
  HWY_ALIGN float square[Cube::side * Cube::side + Cube::side];
  HWY_ALIGN std::uint32_t place[Cube::side * Cube::side + Cube::side];
  std::size_t n;
};

template <bool thin, bool rough>
HWY_INLINE void FindRows(const Cube& at, const SplatBall& ball, const SplatRule& rule, Words count,
                         CubeRows& rows) {
  const Tag d;
  const WordTag dw;
  const Lanes b(ball, rule);
  const Floats zero = hn::Zero(d);
  HWY_ALIGN float x2[Cube::side], y2[Cube::side];
  Squares(at.x.data(), b.x, x2);
  Squares(at.y.data(), b.y, y2);
  Squares(at.z.data(), b.z, rows.z2);
  Floats lowest = hn::Load(d, rows.z2);
  for (std::size_t k = Width(); k < Cube::side; k += Width()) {
    lowest = hn::Min(lowest, hn::Load(d, rows.z2 + k));
  }
  lowest = hn::MinOfLanes(d, lowest);
  std::size_t n = 0;
  for (std::size_t i = 0; i < at.nx; ++i) {
    for (std::size_t j = 0; j < at.ny; j += Width()) {
      const Floats square = hn::Add(All(x2[i]), hn::Load(d, y2 + j));
      const Floats nearest = hn::Add(square, lowest);
      const auto live = hn::Gt(Closeness<thin, rough>(nearest, b, b.amplitude), zero);
      const auto place =
          hn::Add(count, hn::Set(dw, static_cast<std::uint32_t>(Cube::side * i + j)));
      hn::StoreU(hn::Compress(square, live), d, rows.square + n);
      hn::StoreU(hn::Compress(place, hn::RebindMask(dw, live)), dw, rows.place + n);
      n += hn::CountTrue(d, live);
    }
  }
  rows.n = n;
}

/// Calls use(ball, rows) for each ball, in their order.
template <bool thin, bool rough, class Use>
HWY_INLINE void ForBallRows(std::span<const SplatBall> balls, const SplatRule& rule, const Cube& at,
                            Use use) {
  const Words count = hn::Iota(WordTag(), 0U);  // Iota goes through memory
  CubeRows rows[2];
  FindRows<thin, rough>(at, balls[0], rule, count, rows[0]);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (i + 1 < balls.size()) {
      FindRows<thin, rough>(at, balls[i + 1], rule, count, rows[(i + 1) % 2]);
    }
    use(balls[i], rows[i % 2]);
  }
}

}  // namespace hoodoo::tree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
