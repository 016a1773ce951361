// The arithmetic of engine/base/noise.hpp for one vector of points, compiled once per Highway
// target: include it where foreach_target.h includes, and use it inside HWY_NAMESPACE.
#if defined(HOODOO_BASE_NOISE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HOODOO_BASE_NOISE_INL_HPP
#undef HOODOO_BASE_NOISE_INL_HPP
#else
#define HOODOO_BASE_NOISE_INL_HPP
#endif

#include <hwy/highway.h>

#include "engine/base/noise.hpp"

#ifndef HOODOO_BASE_NOISE_SCALE
#define HOODOO_BASE_NOISE_SCALE
namespace hoodoo {

// The corners of a simplex reach to r^2 = 1/2, where they end continuously. 76.88268 is the inverse
// of the largest sum of four corners, taken down so that the result stays within [-1, 1] (found by
// search over the simplex with the worst gradient at each corner).
inline constexpr float simplex_scale = 76.8826F;

}  // namespace hoodoo
#endif

HWY_BEFORE_NAMESPACE();
namespace hoodoo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::ScalableTag<float>;
using Floats = hn::Vec<Tag>;
using SignedTag = hn::RebindToSigned<Tag>;
using WordTag = hn::RebindToUnsigned<Tag>;
using Words = hn::Vec<WordTag>;
using Truth = hn::Mask<Tag>;

struct Noise {
  Floats value, gx, gy, gz;
};

HWY_INLINE Words Hash(Words a, Words b, Words c) {
  const WordTag d;
  Words h = hn::Xor(hn::Xor(a, b), c);
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(d, 0x2c1b3c6dU));
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<12>(h)), hn::Set(d, 0x297a2d39U));
  return hn::Xor(h, hn::ShiftRight<15>(h));
}

/// Adds a corner's (1/2 - r^2)^4 (g . d) and, if asked, its gradient. g is one of the twelve edge
/// directions of a cube, chosen by the low bits of the hash (Perlin 2002).
template <bool gradient>
HWY_INLINE void AddCorner(Noise& sum, Floats x, Floats y, Floats z, Words hash) {
  const Tag d;
  const WordTag dw;
  const Floats zero = hn::Zero(d);
  const Floats r2 = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
  const Floats w = hn::Max(zero, hn::Sub(hn::Set(d, 0.5F), r2));
  const Floats w2 = hn::Mul(w, w), w4 = hn::Mul(w2, w2);
  const Words h = hn::And(hash, hn::Set(dw, 15));
  const Truth first_x = hn::RebindMask(d, hn::Lt(h, hn::Set(dw, 8)));
  const Truth second_y = hn::RebindMask(d, hn::Lt(h, hn::Set(dw, 4)));
  const Truth second_x = hn::RebindMask(d, hn::Eq(hn::And(h, hn::Set(dw, 13)), hn::Set(dw, 12)));
  const Floats one_sign = hn::BitCast(d, hn::ShiftLeft<31>(h));
  const Floats two_sign = hn::BitCast(d, hn::ShiftLeft<30>(hn::And(h, hn::Set(dw, 2))));
  const Floats u = hn::Xor(hn::IfThenElse(first_x, x, y), one_sign);
  const Floats v = hn::Xor(hn::IfThenElse(second_y, y, hn::IfThenElse(second_x, x, z)), two_sign);
  const Floats slope = hn::Add(u, v);
  sum.value = hn::Add(sum.value, hn::Mul(w4, slope));
  if constexpr (gradient) {
    const Floats one = hn::Set(d, 1.0F);
    const Floats g1 = hn::Xor(one, one_sign), g2 = hn::Xor(one, two_sign);
    const Floats gx = hn::Add(hn::IfThenElseZero(first_x, g1), hn::IfThenElseZero(second_x, g2));
    const Floats gy = hn::Add(hn::IfThenZeroElse(first_x, g1), hn::IfThenElseZero(second_y, g2));
    const Floats gz = hn::IfThenZeroElse(hn::Or(second_y, second_x), g2);
    const Floats back = hn::Mul(hn::Mul(hn::Set(d, -8.0F), hn::Mul(w2, w)), slope);
    sum.gx = hn::Add(sum.gx, hn::Add(hn::Mul(w4, gx), hn::Mul(back, x)));
    sum.gy = hn::Add(sum.gy, hn::Add(hn::Mul(w4, gy), hn::Mul(back, y)));
    sum.gz = hn::Add(sum.gz, hn::Add(hn::Mul(w4, gz), hn::Mul(back, z)));
  }
}

/// Not inlined four times over for each instruction set: that would take a compiler minutes under
/// a sanitizer.
inline HWY_NOINLINE void AddCornerApart(Noise& sum, Floats x, Floats y, Floats z, Words hash) {
  AddCorner<true>(sum, x, y, z, hash);
}

/// Lattice coordinates as words. What lies beyond any sensible block is held, so that every
/// instruction set converts it alike.
HWY_INLINE Words Whole(Floats v) {
  const Tag d;
  const Floats held = hn::Min(hn::Max(v, hn::Set(d, -1e9F)), hn::Set(d, 1e9F));
  return hn::BitCast(WordTag(), hn::ConvertTo(SignedTag(), held));
}

/// Simplex noise in [-1, 1] at lattice place (x, y, z), its gradient with respect to that.
/// Source: Gustavson 2005, Simplex noise demystified; corners after Perlin 2002.
template <bool gradient>
HWY_INLINE Noise Simplex(Floats x, Floats y, Floats z, const Octave& o) {
  const Tag d;
  const WordTag dw;
  const Floats third = hn::Set(d, 1.0F / 3), sixth = hn::Set(d, 1.0F / 6), one = hn::Set(d, 1.0F);
  const Floats skew = hn::Mul(hn::Add(hn::Add(x, y), z), third);
  const Floats i = hn::Floor(hn::Add(x, skew)), j = hn::Floor(hn::Add(y, skew)),
               k = hn::Floor(hn::Add(z, skew));
  const Floats back = hn::Mul(hn::Add(hn::Add(i, j), k), sixth);
  const Floats x0 = hn::Sub(x, hn::Sub(i, back)), y0 = hn::Sub(y, hn::Sub(j, back)),
               z0 = hn::Sub(z, hn::Sub(k, back));
  const Truth xy = hn::Ge(x0, y0), xz = hn::Ge(x0, z0), yz = hn::Ge(y0, z0);
  const Truth high_x = hn::And(xy, xz), high_y = hn::AndNot(xy, yz),
              high_z = hn::Not(hn::Or(xz, yz));
  const Truth not_low_x = hn::Or(xy, xz), not_low_y = hn::Or(hn::Not(xy), yz),
              not_low_z = hn::Not(hn::And(xz, yz));

  const Words px = hn::Set(dw, 0x8da6b343U), py = hn::Set(dw, 0xd8163841U),
              pz = hn::Set(dw, 0xcb1ab31fU);
  const Words a = hn::Add(hn::Mul(hn::Add(Whole(i), hn::Set(dw, o.i)), px), hn::Set(dw, o.seed));
  const Words b = hn::Mul(hn::Add(Whole(j), hn::Set(dw, o.j)), py);
  const Words c = hn::Mul(hn::Add(Whole(k), hn::Set(dw, o.k)), pz);
  const auto step = [&](Words word, Words by, Truth m) HWY_ATTR {
    return hn::Add(word, hn::IfThenElseZero(hn::RebindMask(dw, m), by));
  };
  const auto move = [&](Floats v, Truth m, Floats by)
                        HWY_ATTR { return hn::Add(hn::Sub(v, hn::IfThenElseZero(m, one)), by); };
  Noise sum{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const auto add = [&](Floats dx, Floats dy, Floats dz, Words hash) HWY_ATTR {
    if constexpr (gradient) {
      AddCornerApart(sum, dx, dy, dz, hash);
    } else {
      AddCorner<false>(sum, dx, dy, dz, hash);
    }
  };
  add(x0, y0, z0, Hash(a, b, c));
  add(move(x0, high_x, sixth), move(y0, high_y, sixth), move(z0, high_z, sixth),
      Hash(step(a, px, high_x), step(b, py, high_y), step(c, pz, high_z)));
  const Floats twice = hn::Add(sixth, sixth);
  add(move(x0, not_low_x, twice), move(y0, not_low_y, twice), move(z0, not_low_z, twice),
      Hash(step(a, px, not_low_x), step(b, py, not_low_y), step(c, pz, not_low_z)));
  const Floats half = hn::Set(d, 0.5F);
  add(hn::Sub(x0, half), hn::Sub(y0, half), hn::Sub(z0, half),
      Hash(hn::Add(a, px), hn::Add(b, py), hn::Add(c, pz)));
  return sum;
}

/// One vector of points: the normalised sum of all octaves.
template <bool gradient>
HWY_INLINE Noise SumOctaves(const Octave* octaves, std::size_t count, Floats x, Floats y,
                            Floats z) {
  const Tag d;
  const Floats half = hn::Set(d, 0.5F), one = hn::Set(d, 1.0F), zero = hn::Zero(d);
  Noise t{zero, zero, zero, zero};
  for (std::size_t k = 0; k < count; ++k) {
    const Octave& o = octaves[k];
    const Floats f = hn::Set(d, o.frequency);
    const Noise n = Simplex<gradient>(hn::Add(hn::Mul(x, f), hn::Set(d, o.x)),
                                      hn::Add(hn::Mul(y, f), hn::Set(d, o.y)),
                                      hn::Add(hn::Mul(z, f), hn::Set(d, o.z)), o);
    const Floats scale = hn::Set(d, 0.5F * simplex_scale), weight = hn::Set(d, o.amplitude);
    const Floats unit = hn::Min(hn::Max(hn::Add(hn::Mul(n.value, scale), half), zero), one);
    t.value = hn::Add(t.value, hn::Mul(unit, weight));
    if constexpr (gradient) {
      const Floats g = hn::Set(d, 0.5F * simplex_scale * o.amplitude * o.frequency);
      t.gx = hn::Add(t.gx, hn::Mul(n.gx, g));
      t.gy = hn::Add(t.gy, hn::Mul(n.gy, g));
      t.gz = hn::Add(t.gz, hn::Mul(n.gz, g));
    }
  }
  t.value = hn::Min(t.value, one);
  return t;
}

}  // namespace HWY_NAMESPACE
}  // namespace hoodoo
HWY_AFTER_NAMESPACE();

#endif
