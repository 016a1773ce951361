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

/// One vector of edges. All of them have made the same number of steps.
HWY_INLINE void NextSome(const double* low, const double* high, const double* f_low,
                         const double* f_high, double room, double* place) {
  const Tag d;
  const Doubles l = hn::LoadU(d, low), h = hn::LoadU(d, high), half = All(0.5), zero = All(0);
  const Doubles fl = hn::LoadU(d, f_low), fh = hn::LoadU(d, f_high);
  const Doubles middle = hn::Mul(half, hn::Add(l, h)), width = hn::Sub(h, l);
  const Doubles reach = hn::Sub(All(0.5 * RootFinder::tolerance * room), hn::Mul(half, width));
  const Doubles slack = hn::Mul(hn::Mul(All(0.2), width), width);
  const Doubles secant = hn::Div(hn::Sub(hn::Mul(fh, l), hn::Mul(fl, h)), hn::Sub(fh, fl));
  const Doubles side = hn::IfThenElse(hn::Ge(middle, secant), All(1), All(-1));
  const Doubles apart = hn::Abs(hn::Sub(middle, secant));
  const Doubles truncated =
      hn::IfThenElse(hn::Le(slack, apart), hn::Add(secant, hn::Mul(side, slack)), middle);
  const Doubles held = hn::Sub(middle, hn::Mul(side, hn::Max(reach, zero)));
  const auto within = hn::Le(hn::Abs(hn::Sub(truncated, middle)), reach);
  hn::StoreU(hn::IfThenElse(within, truncated, held), d, place);
}

void Next(const double* low, const double* high, const double* f_low, const double* f_high,
          double room, double* place, std::size_t n) {
  for (std::size_t i = 0; i < n; i += hn::Lanes(Tag())) {
    NextSome(low + i, high + i, f_low + i, f_high + i, room, place + i);
  }
}

void Put(double* low, double* high, double* f_low, double* f_high, const double* place,
         const double* value, std::size_t n) {
  const Tag d;
  const Doubles zero = All(0);
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Doubles v = hn::LoadU(d, value + i), t = hn::LoadU(d, place + i);
    const Doubles fl = hn::LoadU(d, f_low + i);
    const auto same = hn::Not(hn::Xor(hn::Gt(v, zero), hn::Gt(fl, zero)));
    hn::StoreU(hn::IfThenElse(same, t, hn::LoadU(d, low + i)), d, low + i);
    hn::StoreU(hn::IfThenElse(same, v, fl), d, f_low + i);
    hn::StoreU(hn::IfThenElse(same, hn::LoadU(d, high + i), t), d, high + i);
    hn::StoreU(hn::IfThenElse(same, hn::LoadU(d, f_high + i), v), d, f_high + i);
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
HWY_EXPORT(Next);
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
  for (auto* lane : {&low_, &high_, &f_low_, &f_high_, &place_}) lane->resize(n + most_lanes);
}

void RootLanes::start(std::span<const std::uint32_t> edges, std::span<const double> low,
                      std::span<const double> high) {
  resize(edges.size());
  room_ = RootFinder::first_room;
  std::copy(edges.begin(), edges.end(), edges_.begin());
  std::fill_n(low_.begin(), n_, 0.0);
  std::fill_n(high_.begin(), n_, 1.0);
  std::copy(low.begin(), low.end(), f_low_.begin());
  std::copy(high.begin(), high.end(), f_high_.begin());
}

std::span<const double> RootLanes::places() {
  HWY_DYNAMIC_DISPATCH(Next)
  (low_.data(), high_.data(), f_low_.data(), f_high_.data(), room_, place_.data(), n_);
  return {place_.data(), n_};
}

void RootLanes::put(std::span<const double> values, std::span<double> roots) {
  HWY_DYNAMIC_DISPATCH(Put)
  (low_.data(), high_.data(), f_low_.data(), f_high_.data(), place_.data(), values.data(), n_);
  room_ *= 0.5;
  // Without a branch that cannot be foreseen: what is not done yet is overwritten later.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    const std::uint32_t edge = edges_[i];
    const double low = low_[i], high = high_[i], f_low = f_low_[i], f_high = f_high_[i];
    roots[edge] = 0.5 * (low + high);
    edges_[kept] = edge;
    low_[kept] = low;
    high_[kept] = high;
    f_low_[kept] = f_low;
    f_high_[kept] = f_high;
    kept += high - low > RootFinder::tolerance ? 1 : 0;
  }
  n_ = kept;
}

}  // namespace hoodoo::volume
#endif
