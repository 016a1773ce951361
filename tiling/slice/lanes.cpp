#include "tiling/slice/lanes.hpp"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/slice/lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo::slice::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using Doubles = hn::Vec<Tag>;
using WholeTag = hn::Rebind<std::int32_t, Tag>;
constexpr std::size_t most = hn::MaxLanes(Tag());

HWY_INLINE Doubles All(double v) { return hn::Set(Tag(), v); }

/// Calls some(i) for whole vectors, and last(i) for what is left from i on.
template <class Some, class Last>
HWY_INLINE void ForVectors(std::size_t n, Some some, Last last) {
  std::size_t i = 0;
  for (; i + hn::Lanes(Tag()) <= n; i += hn::Lanes(Tag())) some(i);
  if (i < n) last(i);
}

HWY_INLINE void MetresOfSome(const std::int32_t* points, const double* origin, double step,
                             double* x, double* y, double* z) {
  const Tag d;
  hn::Vec<WholeTag> px, py, pz;
  hn::LoadInterleaved3(WholeTag(), points, px, py, pz);
  const auto put = [&](hn::Vec<WholeTag> p, double from, double* to) HWY_ATTR {
    hn::StoreU(hn::Mul(hn::Add(All(from), hn::PromoteTo(d, p)), All(step)), d, to);
  };
  put(px, origin[0], x);
  put(py, origin[1], y);
  put(pz, origin[2], z);
}

void Metres(const std::int32_t* points, std::size_t n, const double* origin, double step, double* x,
            double* y, double* z) {
  ForVectors(
      n,
      [&](std::size_t i)
          HWY_ATTR { MetresOfSome(points + 3 * i, origin, step, x + i, y + i, z + i); },
      [&](std::size_t i) HWY_ATTR {
        std::int32_t in[3 * most] = {};
        double out[3][most];
        std::copy(points + 3 * i, points + 3 * n, in);
        MetresOfSome(in, origin, step, out[0], out[1], out[2]);
        std::copy(out[0], out[0] + (n - i), x + i);
        std::copy(out[1], out[1] + (n - i), y + i);
        std::copy(out[2], out[2] + (n - i), z + i);
      });
}

HWY_INLINE void StepSome(const double* above, const double* gx, const double* gy, const double* gz,
                         double* x, double* y, double* z) {
  const Tag d;
  const Doubles a = hn::LoadU(d, gx), b = hn::LoadU(d, gy), c = hn::LoadU(d, gz);
  const Doubles squared = hn::Add(hn::Add(hn::Mul(a, a), hn::Mul(b, b)), hn::Mul(c, c));
  const auto known = hn::Gt(squared, All(0));
  const Doubles by = hn::Div(hn::Neg(hn::LoadU(d, above)), squared);
  hn::StoreU(hn::IfThenElseZero(known, hn::Mul(a, by)), d, x);
  hn::StoreU(hn::IfThenElseZero(known, hn::Mul(b, by)), d, y);
  hn::StoreU(hn::IfThenElseZero(known, hn::Mul(c, by)), d, z);
}

void Steps(const double* above, const double* gx, const double* gy, const double* gz, std::size_t n,
           double* x, double* y, double* z) {
  ForVectors(
      n,
      [&](std::size_t i)
          HWY_ATTR { StepSome(above + i, gx + i, gy + i, gz + i, x + i, y + i, z + i); },
      [&](std::size_t i) HWY_ATTR {
        double in[4][most] = {}, out[3][most];
        std::copy(above + i, above + n, in[0]);
        std::copy(gx + i, gx + n, in[1]);
        std::copy(gy + i, gy + n, in[2]);
        std::copy(gz + i, gz + n, in[3]);
        StepSome(in[0], in[1], in[2], in[3], out[0], out[1], out[2]);
        std::copy(out[0], out[0] + (n - i), x + i);
        std::copy(out[1], out[1] + (n - i), y + i);
        std::copy(out[2], out[2] + (n - i), z + i);
      });
}

}  // namespace hoodoo::slice::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::slice {

HWY_EXPORT(Metres);
HWY_EXPORT(Steps);

void to_metres(std::span<const std::array<std::int32_t, 3>> points,
               const std::array<double, 3>& origin, double step, const Along& out) {
  if (points.empty()) return;
  HWY_DYNAMIC_DISPATCH(Metres)
  (points.data()->data(), points.size(), origin.data(), step, out.x.data(), out.y.data(),
   out.z.data());
}
void newton_steps(std::span<const double> above, const ConstAlong& gradient, const Along& out) {
  HWY_DYNAMIC_DISPATCH(Steps)
  (above.data(), gradient.x.data(), gradient.y.data(), gradient.z.data(), above.size(),
   out.x.data(), out.y.data(), out.z.data());
}

}  // namespace hoodoo::slice
#endif
