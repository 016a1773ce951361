#include <cstddef>

#include "tiling/surface/lanes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/surface/quads.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/fours-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace hoodoo::surface::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using Truth = hn::Mask<Tag>;
using FloatTag = hn::Rebind<float, Tag>;
using WholeTag = hn::Rebind<std::int32_t, Tag>;

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }
template <class V>
HWY_INLINE Doubles Promote(V v) {
  return hn::PromoteTo(Tag(), v);
}

/// As engine/base/vector.hpp, a vector per lane, its sums in the same order.
struct Vec {
  Doubles x, y, z;
};
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

/// Corner c of each quadrilateral from lane i on.
HWY_INLINE Vec Corner(const QuadLanes& quads, const Point* points, std::size_t c, std::size_t i) {
  const std::int32_t* at[hn::MaxLanes(Tag())];
  for (std::size_t n = 0; n < hn::Lanes(Tag()); ++n) at[n] = points[quads.corner[i + n][c]].data();
  hn::Vec<WholeTag> p[4];
  hoodoo::HWY_NAMESPACE::LoadFours(WholeTag(), at, p);
  return {Promote(p[0]), Promote(p[1]), Promote(p[2])};
}
HWY_INLINE Vec Wanted(const QuadLanes& quads, std::size_t i) {
  static_assert(offsetof(volume::Crossing, t) == 0 && offsetof(volume::Crossing, normal) == 4);
  const float* at[hn::MaxLanes(Tag())];
  for (std::size_t n = 0; n < hn::Lanes(Tag()); ++n) at[n] = &quads.crossing[i + n]->t;
  hn::Vec<FloatTag> v[4];
  hoodoo::HWY_NAMESPACE::LoadFours(FloatTag(), at, v);
  return {Promote(v[1]), Promote(v[2]), Promote(v[3])};
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
HWY_INLINE void CutAll(QuadLanes& quads, std::size_t n, const Point* points) {
  const Tag d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Vec c0 = Corner(quads, points, 0, i), c1 = Corner(quads, points, 1, i),
              c2 = Corner(quads, points, 2, i), c3 = Corner(quads, points, 3, i);
    const Vec wanted = Wanted(quads, i);
    const Doubles sign = Promote(hn::Load(FloatTag(), quads.sign + i));
    const Sides from_0 = Divide<axis>(c0, c1, c2, c3, sign, wanted);
    const Sides from_1 = Divide<axis>(c1, c2, c3, c0, sign, wanted);
    const Truth second =
        hn::Or(hn::Not(from_0.valid),
               hn::And(from_1.valid, hn::Not(hn::Ge(from_0.agreement, from_1.agreement))));
    const Doubles diagonal = hn::IfThenElseZero(second, All(1));
    hn::Store(hn::DemoteTo(WholeTag(), diagonal), WholeTag(), quads.diagonal + i);
  }
}

void CutQuads(QuadLanes& quads, std::size_t n, int axis, const Point* points) {
  // What is left of the last vector is a copy of the last quadrilateral.
  for (std::size_t i = n; i % hn::Lanes(Tag()) != 0; ++i) {
    quads.corner[i] = quads.corner[n - 1];
    quads.crossing[i] = quads.crossing[n - 1];
  }
  axis == 0   ? CutAll<0>(quads, n, points)
  : axis == 1 ? CutAll<1>(quads, n, points)
              : CutAll<2>(quads, n, points);
}

/// The corners of both triangles of a quadrilateral whose diagonal begins at corner 0 or 1, seen
/// from the high end of the edge or (2, 3) from the low one.
constexpr std::uint8_t orders[4][2][3] = {
    {{0, 1, 2}, {0, 2, 3}}, {{1, 2, 3}, {1, 3, 0}}, {{0, 2, 1}, {0, 3, 2}}, {{1, 3, 2}, {1, 0, 3}}};

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void Pick(const std::uint32_t* corners, std::size_t order, std::uint32_t* to) {
  for (int i = 0; i < 3; ++i) to[i] = corners[orders[order][0][i]];
  for (int i = 0; i < 3; ++i) to[3 + i] = corners[orders[order][1][i]];
}
#else
/// The same by bytes. The fourth number is to be written over.
struct ByteOrders {
  alignas(16) std::uint8_t of[4][2][16];
};
constexpr ByteOrders byte_orders = [] {
  ByteOrders bytes{};
  for (int order = 0; order < 4; ++order) {
    for (int half = 0; half < 2; ++half) {
      for (int b = 0; b < 12; ++b) {
        bytes.of[order][half][b] =
            static_cast<std::uint8_t>(4 * orders[order][half][b / 4] + b % 4);
      }
    }
  }
  return bytes;
}();
HWY_INLINE void Pick(const std::uint32_t* corners, std::size_t order, std::uint32_t* to) {
  const hn::Full128<std::uint8_t> bytes;
  const hn::Full128<std::uint32_t> d;
  const auto all = hn::BitCast(bytes, hn::LoadU(d, corners));
  for (std::size_t half = 0; half < 2; ++half) {
    const auto picked = hn::TableLookupBytes(all, hn::Load(bytes, byte_orders.of[order][half]));
    hn::StoreU(hn::BitCast(d, picked), d, to + 3 * half);
  }
}
#endif

void DivideQuads(const QuadLanes& quads, std::size_t n, std::uint32_t* triangles) {
  for (std::size_t i = 0; i < n; ++i) {
    const auto order = static_cast<std::size_t>(quads.diagonal[i] + (quads.sign[i] < 0 ? 2 : 0));
    Pick(quads.corner[i].data(), order, triangles + 6 * i);
  }
}

}  // namespace hoodoo::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::surface {

HWY_EXPORT(CutQuads);
HWY_EXPORT(DivideQuads);

void cut(QuadLanes& quads, std::size_t n, int axis, const Point* points) {
  HWY_DYNAMIC_DISPATCH(CutQuads)(quads, n, axis, points);
}
void divide(const QuadLanes& quads, std::size_t n, std::array<std::uint32_t, 3>* triangles) {
  HWY_DYNAMIC_DISPATCH(DivideQuads)(quads, n, triangles->data());
}

}  // namespace hoodoo::surface
#endif
