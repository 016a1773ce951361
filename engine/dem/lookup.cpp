#include "engine/dem/lookup.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/dem/lookup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/fours-inl.hpp"

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

/// The samples around a vector of points, row by row.
class Rows {
 public:
  HWY_INLINE Rows(const Samples& from, const Place& column, const Place& row)
      : from_(from), column_(column), row_(row) {
    inside_ = column.inside(from.width) && row.inside(from.height);
    if (!inside_) return;
    HWY_ALIGN std::int32_t i[hn::MaxLanes(Tag())], j[hn::MaxLanes(Tag())];
    hn::Store(hn::DemoteTo(IndexTag(), column.first), IndexTag(), i);
    hn::Store(hn::DemoteTo(IndexTag(), row.first), IndexTag(), j);
    for (std::size_t n = 0; n < hn::Lanes(Tag()); ++n) {
      at_[n] = from.values + static_cast<std::ptrdiff_t>(j[n]) * from.width + i[n];
    }
  }
  /// The four samples of row k around each point; the rows are asked for in turn.
  HWY_INLINE void get(int k, Doubles* s) {
    const Tag d;
    const IndexTag di;
    if (inside_) {
      hn::Vec<SampleTag> v[4];
      hoodoo::HWY_NAMESPACE::LoadFours(SampleTag(), at_, v);
      for (int l = 0; l < 4; ++l) s[l] = hn::PromoteTo(d, v[l]);
      for (auto& at : at_) at += from_.width;
      return;
    }
    const auto line =
        hn::Mul(hn::DemoteTo(di, row_.sample(k, from_.height)), hn::Set(di, from_.width));
    for (int l = 0; l < 4; ++l) {
      const auto index = hn::Add(line, hn::DemoteTo(di, column_.sample(l, from_.width)));
      s[l] = hn::PromoteTo(d, hn::GatherIndex(SampleTag(), from_.values, index));
    }
  }

 private:
  const Samples& from_;
  const Place &column_, &row_;
  bool inside_;
  const float* at_[hn::MaxLanes(Tag())] = {};
};

/// One vector of points.
template <bool slopes>
HWY_INLINE void LookUpSome(const Samples& from, const double* x, const double* y, double* h,
                           double* hx, double* hy) {
  const Tag d;
  const Place column(hn::LoadU(d, x), from.x0, from.per_x, from.i0);
  const Place row(hn::LoadU(d, y), from.y0, from.per_y, from.j0);
  Rows rows(from, column, row);
  Doubles wx[4], wy[4], dx[4], dy[4], s[4], across[4], sloping[4];
  Weights(column.f, wx);
  Weights(row.f, wy);
  if constexpr (slopes) Derivatives(column.f, dx);
  for (int k = 0; k < 4; ++k) {
    rows.get(k, s);
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

HWY_INLINE Doubles WeightedBy(const double* w, const Doubles* s) {
  const Doubles weights[4] = {All(w[0]), All(w[1]), All(w[2]), All(w[3])};
  return Weighted(weights, s);
}

/// A vector of columns, from row `south` of the samples to row `north`.
template <bool slopes>
HWY_INLINE void LookUpColumns(const Samples& from, const double* x, const SamplePlace* y,
                              std::size_t ny, std::int64_t south, std::int64_t north,
                              std::size_t stride, double* h, double* hx, double* hy) {
  const Tag d;
  const Place column(hn::LoadU(d, x), from.x0, from.per_x, from.i0);
  const bool inside = column.inside(from.width);
  HWY_ALIGN std::int32_t first[hn::MaxLanes(Tag())] = {};
  if (inside) hn::Store(hn::DemoteTo(IndexTag(), column.first), IndexTag(), first);
  Doubles wx[4], dx[4], s[4], across[most_rows], sloping[most_rows];
  Weights(column.f, wx);
  if constexpr (slopes) Derivatives(column.f, dx);
  for (auto row = south; row <= north; ++row) {
    const float* const line =
        from.values + std::clamp<std::int64_t>(row, 0, from.height - 1) * from.width;
    if (inside) {
      const float* at[hn::MaxLanes(Tag())];
      for (std::size_t n = 0; n < hn::Lanes(d); ++n) at[n] = line + first[n];
      hn::Vec<SampleTag> v[4];
      hoodoo::HWY_NAMESPACE::LoadFours(SampleTag(), at, v);
      for (int l = 0; l < 4; ++l) s[l] = hn::PromoteTo(d, v[l]);
    } else {
      for (int l = 0; l < 4; ++l) {
        const auto index = hn::DemoteTo(IndexTag(), column.sample(l, from.width));
        s[l] = hn::PromoteTo(d, hn::GatherIndex(SampleTag(), line, index));
      }
    }
    across[row - south] = Weighted(wx, s);
    if constexpr (slopes) sloping[row - south] = Weighted(dx, s);
  }
  for (std::size_t j = 0; j < ny; ++j) {
    const auto& [row, w, dy] = y[j];
    hn::StoreU(WeightedBy(w, across + (row - south)), d, h + stride * j);
    if constexpr (slopes) {
      const Doubles east = WeightedBy(w, sloping + (row - south));
      const Doubles north_ward = WeightedBy(dy, across + (row - south));
      hn::StoreU(hn::Mul(east, All(from.per_x)), d, hx + stride * j);
      hn::StoreU(hn::Mul(north_ward, All(from.per_y)), d, hy + stride * j);
    }
  }
}

template <bool slopes>
HWY_INLINE void LookUpAllColumns(const Samples& from, const double* x, std::size_t nx,
                                 const SamplePlace* y, std::size_t ny, double* h, double* hx,
                                 double* hy) {
  std::int64_t south = y[0].first, north = y[0].first + 3;
  for (std::size_t j = 1; j < ny; ++j) {
    south = std::min(south, y[j].first);
    north = std::max(north, y[j].first + 3);
  }
  constexpr std::size_t most = hn::MaxLanes(Tag());
  const std::size_t width = hn::Lanes(Tag());
  std::size_t i = 0;
  for (; i + width <= nx; i += width) {
    LookUpColumns<slopes>(from, x + i, y, ny, south, north, nx, h + i, hx + i, hy + i);
  }
  if (i == nx) return;
  // What is left, filled up with copies of the last column.
  double px[most], ph[most * most_rows], phx[most * most_rows], phy[most * most_rows];
  for (std::size_t k = 0; k < width; ++k) px[k] = x[std::min(i + k, nx - 1)];
  LookUpColumns<slopes>(from, px, y, ny, south, north, width, ph, phx, phy);
  for (std::size_t j = 0; j < ny; ++j) {
    std::copy(ph + width * j, ph + width * j + (nx - i), h + nx * j + i);
    if constexpr (slopes) {
      std::copy(phx + width * j, phx + width * j + (nx - i), hx + nx * j + i);
      std::copy(phy + width * j, phy + width * j + (nx - i), hy + nx * j + i);
    }
  }
}

void LookUpGrid(const Samples& from, const double* x, std::size_t nx, const SamplePlace* y,
                std::size_t ny, double* h, double* hx, double* hy) {
  if (hx != nullptr) {
    LookUpAllColumns<true>(from, x, nx, y, ny, h, hx, hy);
  } else {
    LookUpAllColumns<false>(from, x, nx, y, ny, h, h, h);
  }
}

void FindExtremes(const Samples& from, int i0, int j0, int i1, int j1, Extremes* out) {
  const hn::CappedTag<float, 16> d;
  const auto width = static_cast<int>(hn::Lanes(d));
  const float* row = from.values + static_cast<std::ptrdiff_t>(j0) * from.width;
  auto least = hn::Set(d, row[i0]), most = least;
  float low = row[i0], high = low;
  for (int j = j0; j <= j1; ++j, row += from.width) {
    int i = i0;
    for (; i + width <= i1 + 1; i += width) {
      const auto v = hn::LoadU(d, row + i);
      least = hn::Min(least, v);
      most = hn::Max(most, v);
    }
    for (; i <= i1; ++i) {
      low = std::min(low, row[i]);
      high = std::max(high, row[i]);
    }
  }
  out->low = std::min(low, hn::GetLane(hn::MinOfLanes(d, least)));
  out->high = std::max(high, hn::GetLane(hn::MaxOfLanes(d, most)));
}

}  // namespace hoodoo::dem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::dem {

HWY_EXPORT(LookUp);
HWY_EXPORT(LookUpGrid);
HWY_EXPORT(FindExtremes);

void look_up(const Samples& samples, const double* x, const double* y, std::size_t n, double* h,
             double* hx, double* hy) {
  HWY_DYNAMIC_DISPATCH(LookUp)(samples, x, y, n, h, hx, hy);
}
void look_up_grid(const Samples& samples, const double* x, std::size_t nx, const SamplePlace* y,
                  std::size_t ny, double* h, double* hx, double* hy) {
  HWY_DYNAMIC_DISPATCH(LookUpGrid)(samples, x, nx, y, ny, h, hx, hy);
}
Extremes extremes(const Samples& samples, int i0, int j0, int i1, int j1) {
  Extremes e{};
  HWY_DYNAMIC_DISPATCH(FindExtremes)(samples, i0, j0, i1, j1, &e);
  return e;
}

}  // namespace hoodoo::dem
#endif
