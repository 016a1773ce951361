#include "tiling/volume/lanes.hpp"

#include <algorithm>
#include <cstring>

#include "tiling/volume/root.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/volume/lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo::volume::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using FloatTag = hn::CappedTag<float, 16>;

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }

/// A mask as bits; at most 16 lanes.
template <class D, class M>
HWY_INLINE unsigned Bits(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
}

void SignsOfElevations(const double* elevations, double low, double spacing, std::uint16_t* rows) {
  constexpr std::size_t side = 17;
  const Tag d;
  for (int k = 0; k < 16; ++k) {
    const Doubles z = All(low + k * spacing);
    for (std::size_t j = 0; j < 16; ++j) {
      unsigned bits = 0;
      for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        bits |= Bits(d, hn::Gt(hn::LoadU(d, elevations + side * j + i), z)) << i;
      }
      *rows++ = static_cast<std::uint16_t>(bits);
    }
  }
}

/// Rows of a 16 x 16 matrix of bits become columns.
/// Source: Warren 2012, Hacker's Delight, section 7-3.
HWY_INLINE void Transpose(std::uint16_t* m) {
  unsigned mask = 0x00ff;
  for (unsigned step = 8; step != 0; step >>= 1, mask ^= mask << step) {
    for (unsigned k = 0; k < 16; k = (k + step + 1) & ~step) {
      const unsigned swap = (m[k] >> step ^ m[k + step]) & mask;
      m[k] = static_cast<std::uint16_t>(m[k] ^ swap << step);
      m[k + step] = static_cast<std::uint16_t>(m[k + step] ^ swap);
    }
  }
}

void SignsOfValues(const float* values, std::uint16_t* rows) {
  const FloatTag d;
  const auto half = hn::Set(d, 0.5F);
  for (std::size_t j = 0; j < 16; ++j) {
    std::uint16_t along_z[16];
    for (std::size_t i = 0; i < 16; ++i) {
      unsigned bits = 0;
      for (std::size_t k = 0; k < 16; k += hn::Lanes(d)) {
        bits |= Bits(d, hn::Gt(hn::LoadU(d, values + 256 * i + 16 * j + k), half)) << k;
      }
      along_z[i] = static_cast<std::uint16_t>(bits);
    }
    Transpose(along_z);
    for (std::size_t k = 0; k < 16; ++k) rows[16 * k + j] = along_z[k];
  }
}

unsigned SignsOfRow(const float* values, float iso) {
  const FloatTag d;
  unsigned bits = 0;
  for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
    bits |= Bits(d, hn::Gt(hn::LoadU(d, values + i), hn::Set(d, iso))) << i;
  }
  return bits;
}

std::size_t FindCrossed(const Volume::Rows& rows,
                        const std::array<std::array<std::uint16_t, 16>, 3>& near,
                        const std::array<unsigned, 3>& layers, Block& block) {
  for (std::size_t z = 0; z < 16; ++z) {
    std::uint16_t keep[3];
    for (std::size_t a = 0; a < 3; ++a) keep[a] = (layers[a] >> z & 1) != 0 ? 0xffff : 0;
    for (std::size_t y = 0; y < 16; ++y) {
      const std::uint32_t own = rows[z][y];
      const std::uint32_t next[3] = {own >> 1, rows[z][y + 1], rows[z + 1][y]};
      for (std::size_t a = 0; a < 3; ++a) {
        block.crossed[a][16 * z + y] =
            static_cast<std::uint16_t>((own ^ next[a]) & near[a][y] & keep[a]);
      }
    }
  }
  std::size_t count = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t four = 0; four < 256; four += 4) {
      std::uint64_t any = 0;  // most rows have none
      std::memcpy(&any, &block.crossed[a][four], sizeof any);
      const std::uint64_t before = count * 0x0001000100010001U;
      std::memcpy(&block.first[a][four], &before, sizeof before);
      if (any == 0) continue;
      for (std::size_t r = four; r < four + 4; ++r) {
        block.first[a][r] = static_cast<std::uint16_t>(count);
        count += static_cast<std::size_t>(__builtin_popcount(block.crossed[a][r]));
      }
    }
  }
  return count;
}

using Brackets = RootLanes::Brackets;

HWY_INLINE Doubles Secant(Doubles low, Doubles high, Doubles f_low, Doubles f_high) {
  const Doubles at =
      hn::Div(hn::Sub(hn::Mul(f_high, low), hn::Mul(f_low, high)), hn::Sub(f_high, f_low));
  return hn::Min(hn::Max(at, low), high);
}

/// Where the secants of n edges pass through zero.
void Secants(const Brackets& at, double* place, std::size_t n) {
  const Tag d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Doubles l = hn::LoadU(d, at.low + i), h = hn::LoadU(d, at.high + i);
    hn::StoreU(Secant(l, h, hn::LoadU(d, at.f_low + i), hn::LoadU(d, at.f_high + i)), d, place + i);
  }
}

/// RootFinder's put; leaves the root in `place`, and 1 in `done` where it is one.
void Put(const Brackets& at, double* place, const double* value, double* done, std::size_t n) {
  const Tag d;
  const Doubles zero = All(0), one = All(1), half = All(0.5);
  const Doubles most = All(0.5 * RootFinder::tolerance), widest = All(RootFinder::tolerance);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Doubles v = hn::LoadU(d, value + i), t = hn::LoadU(d, place + i);
    Doubles l = hn::LoadU(d, at.low + i), h = hn::LoadU(d, at.high + i);
    Doubles fl = hn::LoadU(d, at.f_low + i), fh = hn::LoadU(d, at.f_high + i);
    const auto is_low = hn::Not(hn::Xor(hn::Gt(v, zero), hn::Gt(fl, zero)));
    const Doubles end = hn::IfThenElse(is_low, l, h), f_end = hn::IfThenElse(is_low, fl, fh);
    const Doubles size = hn::Abs(v);
    const auto near_end =
        hn::Le(hn::Mul(size, hn::Abs(hn::Sub(t, end))), hn::Mul(most, hn::Abs(hn::Sub(v, f_end))));
    const Doubles ratio = hn::Sub(one, hn::Div(v, f_end));
    const auto counts = hn::And(hn::Gt(ratio, zero), hn::Lt(ratio, one));
    const Doubles side = hn::IfThenElse(is_low, All(-1), one);
    const auto again = hn::Eq(side, hn::LoadU(d, at.side + i));
    const Doubles less = hn::IfThenElse(again, hn::IfThenElse(counts, ratio, half), one);
    l = hn::IfThenElse(is_low, t, l);
    h = hn::IfThenElse(is_low, h, t);
    fl = hn::IfThenElse(is_low, v, hn::Mul(fl, less));
    fh = hn::IfThenElse(is_low, hn::Mul(fh, less), v);
    const Doubles width = hn::Sub(h, l);
    const auto near_both =
        hn::And(near_end, hn::Le(hn::Mul(size, width), hn::Mul(most, hn::Abs(hn::Sub(fh, fl)))));
    const auto ends = hn::Or(hn::Le(width, widest), near_both);
    hn::StoreU(l, d, at.low + i);
    hn::StoreU(h, d, at.high + i);
    hn::StoreU(fl, d, at.f_low + i);
    hn::StoreU(fh, d, at.f_high + i);
    hn::StoreU(side, d, at.side + i);
    hn::StoreU(Secant(l, h, fl, fh), d, place + i);
    hn::StoreU(hn::IfThenElseZero(ends, one), d, done + i);
  }
}

HWY_INLINE void PointSome(const double* x, const double* y, const double* z, float* ox, float* oy,
                          float* oz) {
  const Tag d;
  const hn::Rebind<float, Tag> df;
  const Doubles a = hn::Neg(hn::LoadU(d, x)), b = hn::Neg(hn::LoadU(d, y)),
                c = hn::Neg(hn::LoadU(d, z));
  const Doubles length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(a, a), hn::Mul(b, b)), hn::Mul(c, c)));
  const Doubles per = hn::Div(All(1), length);
  const auto known = hn::Gt(length, All(0));
  const auto put = [&](Doubles v, float* to) HWY_ATTR {
    hn::StoreU(hn::DemoteTo(df, hn::IfThenElseZero(known, hn::Mul(v, per))), df, to);
  };
  put(a, ox);
  put(b, oy);
  put(c, oz);
}

void PointAgainst(const double* x, const double* y, const double* z, std::size_t n, float* ox,
                  float* oy, float* oz) {
  constexpr std::size_t most = hn::MaxLanes(Tag());
  const std::size_t width = hn::Lanes(Tag());
  std::size_t i = 0;
  for (; i + width <= n; i += width) PointSome(x + i, y + i, z + i, ox + i, oy + i, oz + i);
  if (i == n) return;
  double in[3][most] = {};
  float out[3][most];
  std::copy(x + i, x + n, in[0]);
  std::copy(y + i, y + n, in[1]);
  std::copy(z + i, z + n, in[2]);
  PointSome(in[0], in[1], in[2], out[0], out[1], out[2]);
  std::copy(out[0], out[0] + (n - i), ox + i);
  std::copy(out[1], out[1] + (n - i), oy + i);
  std::copy(out[2], out[2] + (n - i), oz + i);
}

}  // namespace hoodoo::volume::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::volume {

HWY_EXPORT(SignsOfElevations);
HWY_EXPORT(SignsOfValues);
HWY_EXPORT(SignsOfRow);
HWY_EXPORT(FindCrossed);
HWY_EXPORT(Secants);
HWY_EXPORT(Put);
HWY_EXPORT(PointAgainst);

namespace {
constexpr std::size_t most_lanes = 8;  // room for a last vector that is not full
}

void find_signs(std::span<const double, 289> elevations, double z, double spacing, SignRows rows) {
  HWY_DYNAMIC_DISPATCH(SignsOfElevations)(elevations.data(), z, spacing, rows.data());
}
void find_signs(std::span<const float, 4096> values, SignRows rows) {
  HWY_DYNAMIC_DISPATCH(SignsOfValues)(values.data(), rows.data());
}
unsigned find_signs(std::span<const float, 16> values, float iso) {
  return HWY_DYNAMIC_DISPATCH(SignsOfRow)(values.data(), iso);
}
std::size_t find_crossed(const Volume::Rows& rows,
                         const std::array<std::array<std::uint16_t, 16>, 3>& near,
                         const std::array<unsigned, 3>& layers, Block& block) {
  return HWY_DYNAMIC_DISPATCH(FindCrossed)(rows, near, layers, block);
}

void point_against(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                   const std::array<std::span<float>, 3>& out) {
  HWY_DYNAMIC_DISPATCH(PointAgainst)
  (x.data(), y.data(), z.data(), x.size(), out[0].data(), out[1].data(), out[2].data());
}

void RootLanes::resize(std::size_t n) {
  n_ = n;
  edges_.resize(n);
  for (auto* lane : {&low_, &high_, &f_low_, &f_high_, &side_, &place_, &done_}) {
    lane->resize(n + most_lanes);
  }
}

void RootLanes::start(std::span<const std::uint32_t> edges, std::span<const double> low,
                      std::span<const double> high) {
  resize(edges.size());
  steps_ = 0;
  std::copy(edges.begin(), edges.end(), edges_.begin());
  std::fill_n(low_.begin(), n_, 0.0);
  std::fill_n(high_.begin(), n_, 1.0);
  std::fill_n(side_.begin(), n_, 0.0);
  std::copy(low.begin(), low.end(), f_low_.begin());
  std::copy(high.begin(), high.end(), f_high_.begin());
  HWY_DYNAMIC_DISPATCH(Secants)(brackets(), place_.data(), n_);
}

RootLanes::Brackets RootLanes::brackets() {
  return {low_.data(), high_.data(), f_low_.data(), f_high_.data(), side_.data()};
}

std::span<const double> RootLanes::places() {
  if (steps_ >= RootFinder::most_secants) {
    for (std::size_t i = 0; i < n_; ++i) place_[i] = 0.5 * (low_[i] + high_[i]);
  }
  return {place_.data(), n_};
}

void RootLanes::put(std::span<const double> values, std::span<double> roots) {
  HWY_DYNAMIC_DISPATCH(Put)(brackets(), place_.data(), values.data(), done_.data(), n_);
  ++steps_;
  // Without a branch that cannot be foreseen: what is not done yet is overwritten later.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    const std::uint32_t edge = edges_[i];
    const double low = low_[i], high = high_[i], f_low = f_low_[i], f_high = f_high_[i];
    const double side = side_[i], place = place_[i], done = done_[i];
    roots[edge] = place;
    edges_[kept] = edge;
    low_[kept] = low;
    high_[kept] = high;
    f_low_[kept] = f_low;
    f_high_[kept] = f_high;
    side_[kept] = side;
    place_[kept] = place;
    kept += done == 0 ? 1 : 0;
  }
  n_ = kept;
}

}  // namespace hoodoo::volume
#endif
