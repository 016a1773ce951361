#include "engine/dem/lookup.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/dem/lookup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo::dem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using IndexTag = hn::Rebind<std::int32_t, Tag>;
using SampleTag = hn::Rebind<float, Tag>;

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }

/// The first of four samples around a coordinate, counted from the window's, and how far it lies
/// between the middle ones.
struct Place {
  Doubles first, f;
  HWY_INLINE Place(Doubles at, double from, double per, std::int64_t first_pixel) {
    Doubles u = hn::Sub(hn::Mul(hn::Sub(at, All(from)), All(per)), All(0.5));
    // Within what an index holds: a pixel so far away is edge anyhow.
    u = hn::Min(hn::Max(u, All(-1e15)), All(1e15));
    const Doubles whole = hn::Floor(u);
    f = hn::Sub(u, whole);
    first = hn::Sub(whole, All(static_cast<double>(first_pixel) + 1));
  }
  HWY_INLINE bool inside(std::int32_t size) const {
    return hn::AllTrue(Tag(), hn::And(hn::Ge(first, All(0)), hn::Le(first, All(size - 4.0))));
  }
  /// Sample `l` of the four; beyond the window its edge continues.
  HWY_INLINE Doubles sample(int l, std::int32_t size) const {
    return hn::Min(hn::Max(hn::Add(first, All(l)), All(0)), All(size - 1.0));
  }
};

/// As keys.hpp has them.
HWY_INLINE void Weights(Doubles f, Doubles* w) {
  const Doubles g = hn::Mul(f, f), half = All(0.5);
  w[0] = hn::Mul(f, hn::Sub(hn::Sub(f, half), hn::Mul(half, g)));
  w[1] = hn::Add(All(1), hn::Mul(g, hn::Sub(hn::Mul(All(1.5), f), All(2.5))));
  w[2] = hn::Mul(f, hn::Sub(hn::Add(half, hn::Mul(All(2), f)), hn::Mul(All(1.5), g)));
  w[3] = hn::Mul(g, hn::Sub(hn::Mul(half, f), half));
}
HWY_INLINE void Derivatives(Doubles f, Doubles* d) {
  const Doubles g = hn::Mul(f, f), half = All(0.5);
  d[0] = hn::Sub(hn::Sub(hn::Mul(All(2), f), half), hn::Mul(All(1.5), g));
  d[1] = hn::Sub(hn::Mul(All(4.5), g), hn::Mul(All(5), f));
  d[2] = hn::Sub(hn::Add(half, hn::Mul(All(4), f)), hn::Mul(All(4.5), g));
  d[3] = hn::Sub(hn::Mul(All(1.5), g), f);
}
HWY_INLINE Doubles Weighted(const Doubles* w, const Doubles* s) {
  return hn::Add(hn::Add(hn::Add(hn::Mul(w[0], s[0]), hn::Mul(w[1], s[1])), hn::Mul(w[2], s[2])),
                 hn::Mul(w[3], s[3]));
}

/// The four samples of row k around each point.
HWY_INLINE void Row(const Samples& from, const Place& column, const Place& row, bool inside, int k,
                    Doubles* s) {
  const Tag d;
  const IndexTag di;
  const SampleTag df;
  const auto wide = hn::Set(di, from.width);
  if (inside) {
    const auto corner = hn::Add(hn::Mul(hn::DemoteTo(di, hn::Add(row.first, All(k))), wide),
                                hn::DemoteTo(di, column.first));
    for (int l = 0; l < 4; ++l) {
      s[l] = hn::PromoteTo(d, hn::GatherIndex(df, from.values + l, corner));
    }
    return;
  }
  const auto line = hn::Mul(hn::DemoteTo(di, row.sample(k, from.height)), wide);
  for (int l = 0; l < 4; ++l) {
    const auto index = hn::Add(line, hn::DemoteTo(di, column.sample(l, from.width)));
    s[l] = hn::PromoteTo(d, hn::GatherIndex(df, from.values, index));
  }
}

/// One vector of points.
template <bool slopes>
HWY_INLINE void LookUpSome(const Samples& from, const double* x, const double* y, double* h,
                           double* hx, double* hy) {
  const Tag d;
  const Place column(hn::LoadU(d, x), from.x0, from.per_x, from.i0);
  const Place row(hn::LoadU(d, y), from.y0, from.per_y, from.j0);
  const bool inside = column.inside(from.width) && row.inside(from.height);
  Doubles wx[4], wy[4], dx[4], dy[4], s[4], across[4], sloping[4];
  Weights(column.f, wx);
  Weights(row.f, wy);
  if constexpr (slopes) Derivatives(column.f, dx);
  for (int k = 0; k < 4; ++k) {
    Row(from, column, row, inside, k, s);
    across[k] = Weighted(wx, s);
    if constexpr (slopes) sloping[k] = Weighted(dx, s);
  }
  hn::StoreU(Weighted(wy, across), d, h);
  if constexpr (slopes) {
    Derivatives(row.f, dy);
    hn::StoreU(hn::Mul(Weighted(wy, sloping), All(from.per_x)), d, hx);
    hn::StoreU(hn::Mul(Weighted(dy, across), All(from.per_y)), d, hy);
  }
}

template <bool slopes>
HWY_INLINE void LookUpAll(const Samples& from, const double* x, const double* y, std::size_t n,
                          double* h, double* hx, double* hy) {
  constexpr std::size_t most = hn::MaxLanes(Tag());
  const std::size_t width = hn::Lanes(Tag());
  std::size_t i = 0;
  for (; i + width <= n; i += width) LookUpSome<slopes>(from, x + i, y + i, h + i, hx + i, hy + i);
  if (i == n) return;
  // What is left, filled up with copies of the last point.
  double px[most], py[most], ph[most], phx[most], phy[most];
  for (std::size_t k = 0; k < width; ++k) {
    px[k] = x[std::min(i + k, n - 1)];
    py[k] = y[std::min(i + k, n - 1)];
  }
  LookUpSome<slopes>(from, px, py, ph, phx, phy);
  std::copy(ph, ph + (n - i), h + i);
  if constexpr (slopes) {
    std::copy(phx, phx + (n - i), hx + i);
    std::copy(phy, phy + (n - i), hy + i);
  }
}

void LookUp(const Samples& from, const double* x, const double* y, std::size_t n, double* h,
            double* hx, double* hy) {
  if (hx != nullptr) {
    LookUpAll<true>(from, x, y, n, h, hx, hy);
  } else {
    LookUpAll<false>(from, x, y, n, h, h, h);
  }
}

}  // namespace hoodoo::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::dem {

HWY_EXPORT(LookUp);

void look_up(const Samples& samples, const double* x, const double* y, std::size_t n, double* h,
             double* hx, double* hy) {
  HWY_DYNAMIC_DISPATCH(LookUp)(samples, x, y, n, h, hx, hy);
}

}  // namespace hoodoo::dem
#endif
