#include "tiling/surface/lanes.hpp"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/surface/lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/fours-inl.hpp"
#include "tiling/surface/qef.hpp"
#include "tiling/surface/tables.hpp"

#ifndef HOODOO_SURFACE_LANES_TABLES
#define HOODOO_SURFACE_LANES_TABLES
namespace hoodoo::surface {

/// Where the crossing of an edge is listed in a CellRow: axis, place beside, and step in x.
struct EdgePlace {
  std::uint8_t axis, beside, step;
};
inline constexpr auto edge_places = [] {
  std::array<EdgePlace, 12> places{};
  for (unsigned e = 0; e < 12; ++e) {
    const std::size_t a = e / 4;
    std::array<unsigned, 3> offset{};
    offset[next_axis(a)] = e & 1;
    offset[last_axis(a)] = e >> 1 & 1;
    places[e] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(offset[1] + 2 * offset[2]),
                 static_cast<std::uint8_t>(offset[0])};
  }
  return places;
}();
inline constexpr auto edge_codes = [] {
  std::array<std::int32_t, 12> codes{};
  for (unsigned e = 0; e < 12; ++e) {
    codes[e] = edge_places[e].step | edge_places[e].beside << 1 | 8 << edge_places[e].axis;
  }
  return codes;
}();

/// The edges of a mask with one sheet whatever its neighbours; none of another mask.
struct LoneSheet {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 12> edges{};
};
inline const std::array<LoneSheet, 256>& lone_sheets() {
  static const auto table = [] {
    std::array<LoneSheet, 256> t;
    for (unsigned mask = 0; mask < 256; ++mask) {
      const Case& sheets = cases()[mask];
      if (sheets.sheets != 1 || sheets.bad_face >= 0) continue;
      for (std::uint8_t e = 0; e < 12; ++e) {
        if (sheets.sheet[e] == 0) t[mask].edges[t[mask].count++] = e;
      }
    }
    return t;
  }();
  return table;
}

}  // namespace hoodoo::surface
#endif

HWY_BEFORE_NAMESPACE();
namespace hoodoo::surface::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using Truth = hn::Mask<Tag>;
using FloatTag = hn::Rebind<float, Tag>;
using WholeTag = hn::Rebind<std::int32_t, Tag>;

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }

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
HWY_INLINE Vec Where(Truth m, const Vec& a, const Vec& b) {
  return {hn::IfThenElse(m, a.x, b.x), hn::IfThenElse(m, a.y, b.y), hn::IfThenElse(m, a.z, b.z)};
}
HWY_INLINE Vec OnlyWhere(Truth m, const Vec& a) {
  return {hn::IfThenElseZero(m, a.x), hn::IfThenElseZero(m, a.y), hn::IfThenElseZero(m, a.z)};
}
template <class V>
HWY_INLINE Doubles Promote(V v) {
  return hn::PromoteTo(Tag(), v);
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

HWY_INLINE hn::Vec<WholeTag> Snap(Doubles v, Doubles units) {
  const Doubles one = All(1);
  const Doubles inside = hn::Min(hn::Max(v, All(0)), one);
  const Doubles step = hn::Floor(hn::Add(hn::Mul(inside, units), All(0.5)));
  return hn::DemoteTo(WholeTag(), hn::Min(hn::Max(step, one), hn::Sub(units, one)));
}

/// Plane k of a vector of sheets: its crossing in the frame of the cell, and its normal.
struct Plane {
  Vec point, normal;
};
HWY_INLINE Plane LoadPlane(const SheetLanes& sheets, std::size_t k, std::size_t i) {
  const FloatTag d;
  const WholeTag dw;
  auto t = hn::Zero(d), x = t, y = t, z = t;
  hn::LoadInterleaved4(d, sheets.plane[k][i].data(), t, x, y, z);
  const auto code = hn::Load(dw, sheets.edge[k] + i);
  const auto along = [&](int axis) HWY_ATTR {
    const auto here = hn::TestBit(code, hn::Set(dw, 8 << axis));
    const auto far = hn::TestBit(code, hn::Set(dw, 1 << axis));
    const auto offset = hn::IfThenElseZero(hn::RebindMask(d, far), hn::Set(d, 1.0F));
    return Promote(hn::IfThenElse(hn::RebindMask(d, here), t, offset));
  };
  return {{along(0), along(1), along(2)}, {Promote(x), Promote(y), Promote(z)}};
}

/// The vertex of n planes, in the lanes that are wanted. An absent plane is 0.
HWY_INLINE Vec Vertex(const Plane* planes, std::size_t n, const Vec& mean, Truth wanted) {
  const Doubles zero = All(0);
  Symmetric m{zero, zero, zero, zero, zero, zero};
  Vec b{zero, zero, zero}, direction{zero, zero, zero};
  for (std::size_t k = 0; k < n; ++k) {
    const auto& [point, normal] = planes[k];
    m.add(normal);
    b = b + normal * Dot(normal, point - mean);
    direction = direction + normal;
  }
  const Doubles squared = Dot(direction, direction), rayleigh = Dot(direction, m * direction);
  const Doubles rest = hn::Sub(hn::Mul(m.trace(), squared), rayleigh);
  const Truth one_counts =
      hn::And(hn::Gt(squared, zero), hn::Lt(rest, hn::Mul(All(least_eigenvalue), rayleigh)));
  const Vec v = m * (m * (m * direction));
  Vec best = v * hn::Div(Dot(v, b), Dot(v, m * v));
  const Truth others = hn::And(wanted, hn::Not(one_counts));
  if (!hn::AllFalse(Tag(), others)) best = Where(one_counts, best, Solve(m, b, others));
  return mean + best;
}

HWY_INLINE void SolveSome(SheetLanes& sheets, std::size_t i, Doubles units) {
  const Tag d;
  const Doubles count = hn::Load(d, sheets.count + i), zero = All(0);
  std::size_t most = 0;
  while (most < SheetLanes::most_planes &&
         !hn::AllFalse(d, hn::Gt(count, All(static_cast<double>(most))))) {
    ++most;
  }
  Plane planes[SheetLanes::most_planes];
  Vec mean{zero, zero, zero};
  for (std::size_t k = 0; k < most; ++k) {
    const Truth has = hn::Gt(count, All(static_cast<double>(k)));
    const Plane plane = LoadPlane(sheets, k, i);
    planes[k] = {OnlyWhere(has, plane.point), OnlyWhere(has, plane.normal)};
    mean = mean + planes[k].point;
  }
  mean = mean * hn::Div(All(1), count);
  const Vec best = Vertex(planes, most, mean, hn::Gt(count, zero));
  hn::StoreInterleaved3(Snap(best.x, units), Snap(best.y, units), Snap(best.z, units), WholeTag(),
                        sheets.point[i].data());
  hn::Store(mean.x, d, sheets.mean[0] + i);
  hn::Store(mean.y, d, sheets.mean[1] + i);
  hn::Store(mean.z, d, sheets.mean[2] + i);
}

void SolveSheets(SheetLanes& sheets, std::size_t n, int units) {
  for (std::size_t i = n; i % hn::Lanes(Tag()) != 0; ++i) sheets.count[i] = 1;
  const Doubles per_cell = All(units);
  for (std::size_t i = 0; i < n; i += hn::Lanes(Tag())) SolveSome(sheets, i, per_cell);
}

/// Number l of the upright edges' crossings (t, normal) beside a row of cells: of the edge at x, at
/// [l][x]. An edge that is not crossed has those of another.
using Upright = float[4][24];
HWY_INLINE void LoadUpright(const CellRow::Edges& edges, bool beyond, Upright& to) {
  static_assert(offsetof(volume::Crossing, t) == 0 && offsetof(volume::Crossing, normal) == 4);
  const FloatTag d;
  const float* at[16];
  std::size_t before = 0;
  for (std::size_t x = 0; x < 16; ++x) {
    const bool crossed = (edges.crossed >> x & 1) != 0;
    at[x] = &edges.own[crossed ? before : 0].t;
    before += crossed ? 1 : 0;
  }
  for (std::size_t x = 0; x < 16; x += hn::Lanes(d)) {
    hn::Vec<FloatTag> v[4];
    hoodoo::HWY_NAMESPACE::LoadFours(d, at + x, v);
    for (std::size_t l = 0; l < 4; ++l) hn::StoreU(v[l], d, to[l] + x);
  }
  const volume::Crossing& last = beyond ? *edges.next : *edges.own;
  to[0][16] = last.t;
  to[1][16] = last.normal.x, to[2][16] = last.normal.y, to[3][16] = last.normal.z;
}

void SolveFlat(const CellRow& row, unsigned flat, int units, Point* points) {
  const Tag d;
  const FloatTag df;
  const WholeTag dw;
  Upright upright[2];
  for (std::size_t beside = 0; beside < 2; ++beside) {
    LoadUpright(row.edges[2][beside], (flat >> 15) != 0, upright[beside]);
  }
  const Doubles per_cell = All(units), zero = All(0);
  const auto corner = [&](std::size_t a) HWY_ATTR { return hn::Set(dw, row.corner[a]); };
  for (unsigned x = 0; x < 16; x += static_cast<unsigned>(hn::Lanes(d))) {
    const std::uint8_t bits[8] = {static_cast<std::uint8_t>(flat >> x)};
    const Truth wanted = hn::LoadMaskBits(d, bits);
    if (hn::AllFalse(d, wanted)) continue;
    Plane planes[4];
    Vec mean{zero, zero, zero};
    for (unsigned k = 0; k < 4; ++k) {
      const auto number = [&](int l) HWY_ATTR {
        return Promote(hn::LoadU(df, upright[k >> 1][l] + x + (k & 1)));
      };
      planes[k] = {{All(k & 1), All(k >> 1), number(0)}, {number(1), number(2), number(3)}};
      mean = mean + planes[k].point;
    }
    mean = mean * All(0.25);
    const Vec best = Vertex(planes, 4, mean, wanted);
    const auto cell = hn::Mul(hn::Iota(dw, static_cast<std::int32_t>(x)),
                              hn::Set(dw, static_cast<std::int32_t>(units)));
    hn::StoreInterleaved3(hn::Add(Snap(best.x, per_cell), hn::Add(corner(0), cell)),
                          hn::Add(Snap(best.y, per_cell), corner(1)),
                          hn::Add(Snap(best.z, per_cell), corner(2)), dw, points[x].data());
  }
}

/// The crossing of `edge` of cell x, into plane k of a lane.
HWY_INLINE void PutPlane(const CellRow& row, unsigned x, unsigned edge, SheetLanes& sheets,
                         std::size_t k, std::size_t lane) {
  const auto& [axis, beside, step] = edge_places[edge];
  const CellRow::Edges& edges = row.edges[axis][beside];
  const unsigned at = x + step, before = edges.crossed & ((1U << (at & 15)) - 1);
  const volume::Crossing* crossing = at < 16 ? edges.own + __builtin_popcount(before) : edges.next;
  const auto& n = crossing->normal;
  sheets.plane[k][lane] = {crossing->t, n.x, n.y, n.z};
  sheets.edge[k][lane] = edge_codes[edge];
}
HWY_INLINE void PutCell(const CellRow& row, unsigned x, std::size_t count, int units,
                        SheetLanes& sheets, std::size_t lane) {
  sheets.count[lane] = static_cast<double>(count);
  sheets.corner[0][lane] = row.corner[0] + static_cast<int>(x) * units;
  sheets.corner[1][lane] = row.corner[1];
  sheets.corner[2][lane] = row.corner[2];
}

unsigned GatherRow(const CellRow& row, unsigned active, int units, SheetLanes& sheets,
                   std::size_t& lane, std::uint32_t vertex, std::uint32_t* vertices) {
  const auto& table = lone_sheets();
  std::size_t n = lane;
  for (; active != 0 && n < SheetLanes::most; active &= active - 1, ++n) {
    const auto x = static_cast<unsigned>(__builtin_ctz(active));
    const LoneSheet& sheet = table[row.mask(x)];
    if (sheet.count == 0) break;
    for (std::size_t k = 0; k < sheet.count; ++k) PutPlane(row, x, sheet.edges[k], sheets, k, n);
    PutCell(row, x, sheet.count, units, sheets, n);
    sheets.number[n] = vertices[x] = vertex++;
  }
  lane = n;
  return active;
}
void GatherSheet(const CellRow& row, unsigned x, unsigned edges, int units, SheetLanes& sheets,
                 std::size_t lane) {
  std::size_t k = 0;
  for (; edges != 0; edges &= edges - 1, ++k) {
    PutPlane(row, x, static_cast<unsigned>(__builtin_ctz(edges)), sheets, k, lane);
  }
  PutCell(row, x, k, units, sheets, lane);
}

}  // namespace hoodoo::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::surface {

HWY_EXPORT(SolveSheets);
HWY_EXPORT(SolveFlat);
HWY_EXPORT(GatherRow);
HWY_EXPORT(GatherSheet);

std::int32_t edge_code(unsigned edge) { return edge_codes[edge]; }

void solve(SheetLanes& sheets, std::size_t n, int units) {
  HWY_DYNAMIC_DISPATCH(SolveSheets)(sheets, n, units);
}
void solve_flat(const CellRow& row, unsigned flat, int units, std::array<Point, 16>& points) {
  HWY_DYNAMIC_DISPATCH(SolveFlat)(row, flat, units, points.data());
}
unsigned gather(const CellRow& row, unsigned active, int units, SheetLanes& sheets,
                std::size_t& lane, std::uint32_t vertex, std::uint32_t* vertices) {
  return HWY_DYNAMIC_DISPATCH(GatherRow)(row, active, units, sheets, lane, vertex, vertices);
}
void gather(const CellRow& row, unsigned x, unsigned edges, int units, SheetLanes& sheets,
            std::size_t lane) {
  HWY_DYNAMIC_DISPATCH(GatherSheet)(row, x, edges, units, sheets, lane);
}

}  // namespace hoodoo::surface
#endif
