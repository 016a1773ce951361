// Four neighbours at each of several places, compiled once per Highway target: include it where
// foreach_target.h includes, and use it inside HWY_NAMESPACE.
#if defined(HOODOO_BASE_FOURS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HOODOO_BASE_FOURS_INL_HPP
#undef HOODOO_BASE_FOURS_INL_HPP
#else
#define HOODOO_BASE_FOURS_INL_HPP
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
template <class D>
HWY_INLINE void LoadFours(D d, const hn::TFromD<D>* const* at, hn::Vec<D>* v) {
  for (int l = 0; l < 4; ++l) v[l] = hn::Set(d, at[0][l]);
}
#else
template <class D>
requires(hn::MaxLanes(D()) == 8) HWY_INLINE hn::Vec<D> LoadFour(D d,
                                                                const hn::TFromD<D>* const* at) {
  const hn::Half<D> dh;
  return hn::Combine(d, hn::LoadU(dh, at[4]), hn::LoadU(dh, at[0]));
}
template <class D>
requires(hn::MaxLanes(D()) == 4) HWY_INLINE hn::Vec<D> LoadFour(D d,
                                                                const hn::TFromD<D>* const* at) {
  return hn::LoadU(d, at[0]);
}

/// Four 32-bit numbers at each of as many places as D has lanes, at most 8: number l of all of them
/// in v[l]. Each four are one load, and to transpose them costs less than to gather.
template <class D>
requires(hn::MaxLanes(D()) > 2) HWY_INLINE
    void LoadFours(D d, const hn::TFromD<D>* const* at, hn::Vec<D>* v) {
  const auto a = LoadFour(d, at), b = LoadFour(d, at + 1), c = LoadFour(d, at + 2),
             e = LoadFour(d, at + 3);
  const auto ac = hn::InterleaveLower(d, a, c), be = hn::InterleaveLower(d, b, e);
  const auto ac2 = hn::InterleaveUpper(d, a, c), be2 = hn::InterleaveUpper(d, b, e);
  v[0] = hn::InterleaveLower(d, ac, be);
  v[1] = hn::InterleaveUpper(d, ac, be);
  v[2] = hn::InterleaveLower(d, ac2, be2);
  v[3] = hn::InterleaveUpper(d, ac2, be2);
}
template <class D>
requires(hn::MaxLanes(D()) == 2) HWY_INLINE
    void LoadFours(D d, const hn::TFromD<D>* const* at, hn::Vec<D>* v) {
  const hn::Twice<D> dt;
  const auto a = hn::LoadU(dt, at[0]), b = hn::LoadU(dt, at[1]);
  const auto first = hn::InterleaveLower(dt, a, b), last = hn::InterleaveUpper(dt, a, b);
  v[0] = hn::LowerHalf(d, first);
  v[1] = hn::UpperHalf(d, first);
  v[2] = hn::LowerHalf(d, last);
  v[3] = hn::UpperHalf(d, last);
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace hoodoo
HWY_AFTER_NAMESPACE();

#endif
