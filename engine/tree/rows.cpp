#include "engine/tree/rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/tree/rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo::tree::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, Cube::side>;
using Floats = hn::Vec<Tag>;

HWY_INLINE Floats All(float v) { return hn::Set(Tag(), v); }
/// As dual.hpp has them: `a` where the two are equal, or one is no number.
HWY_INLINE Floats Smaller(Floats a, Floats b) { return hn::IfThenElse(hn::Lt(b, a), b, a); }
HWY_INLINE Floats Larger(Floats a, Floats b) { return hn::IfThenElse(hn::Gt(b, a), b, a); }

/// In [0, 1], never -0; 0 for what is no number: of those, Max gives its second argument.
HWY_INLINE Floats Held(Floats v) { return hn::Min(hn::Max(v, hn::Zero(Tag())), All(1.0F)); }

void StepRows(const Cube& at, const float* h, const float* scale, const float* edge, float* out) {
  const Tag d;
  const Floats half = All(0.5F), most = All(1.0F), least = All(-1.0F), slope = All(1.5F);
  for (std::size_t i = 0; i < at.nx; ++i) {
    for (std::size_t j = 0; j < at.ny; ++j) {
      const std::size_t n = Cube::side * i + j;
      const Floats top = All(h[n]), by = All(scale[n]), prism = All(edge[n]);
      for (std::size_t k = 0; k < Cube::side; k += hn::Lanes(d)) {
        const Floats u = hn::Mul(hn::Sub(top, hn::Load(d, at.z.data() + k)), by);
        const Floats c = hn::Min(hn::Max(u, least), most);
        const Floats s = hn::Mul(c, hn::Sub(slope, hn::Mul(half, hn::Mul(c, c))));
        const Floats f = hn::Add(half, hn::Mul(half, s));
        hn::StoreU(hn::Min(f, prism), d, out + Cube::side * n + k);
      }
    }
    for (std::size_t n = Cube::side * i + at.ny; n < Cube::side * (i + 1); ++n) {
      for (std::size_t k = 0; k < Cube::side; ++k) out[Cube::side * n + k] = 0;
    }
  }
}

template <class Join>
HWY_INLINE void JoinRows(std::size_t nx, float* f, const float* tree, Join join) {
  const Tag d;
  for (std::size_t n = 0; n < nx * Cube::side * Cube::side; n += hn::Lanes(d)) {
    hn::StoreU(join(hn::LoadU(d, f + n), hn::LoadU(d, tree + n)), d, f + n);
  }
}

void ApplyRows(Operation operation, std::size_t nx, float* f, const float* tree) {
  switch (operation) {
    case Operation::blend:
      return JoinRows(nx, f, tree, [](Floats a, Floats b) HWY_ATTR { return Held(hn::Add(a, b)); });
    case Operation::carve:
      return JoinRows(nx, f, tree, [](Floats a, Floats b) HWY_ATTR { return Held(hn::Sub(a, b)); });
    case Operation::unite:
      return JoinRows(nx, f, tree, [](Floats a, Floats b) HWY_ATTR { return Held(Larger(a, b)); });
    case Operation::difference:
      return JoinRows(nx, f, tree, [](Floats a, Floats b) HWY_ATTR {
        return Held(Smaller(a, hn::Sub(All(1.0F), b)));
      });
    case Operation::intersect:
      return JoinRows(nx, f, tree, [](Floats a, Floats b) HWY_ATTR { return Held(Smaller(a, b)); });
    case Operation::replace:
      return JoinRows(nx, f, tree, [](Floats, Floats b) HWY_ATTR { return Held(b); });
  }
}

void UniteRows(std::size_t nx, float* f, const float* other) {
  JoinRows(nx, f, other, [](Floats a, Floats b) HWY_ATTR { return Larger(a, b); });
}

}  // namespace hoodoo::tree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::tree {

HWY_EXPORT(StepRows);
HWY_EXPORT(ApplyRows);
HWY_EXPORT(UniteRows);

void step_rows(const Cube& at, const std::array<float, Columns::count>& h,
               const std::array<float, Columns::count>& scale,
               const std::array<float, Columns::count>& edge, CubeValues out) {
  HWY_DYNAMIC_DISPATCH(StepRows)(at, h.data(), scale.data(), edge.data(), out.data());
}
void apply_rows(Operation operation, std::size_t nx, CubeValues f,
                std::span<const float, Cube::size> tree) {
  HWY_DYNAMIC_DISPATCH(ApplyRows)(operation, nx, f.data(), tree.data());
}
void unite_rows(std::size_t nx, CubeValues f, std::span<const float, Cube::size> other) {
  HWY_DYNAMIC_DISPATCH(UniteRows)(nx, f.data(), other.data());
}

}  // namespace hoodoo::tree
#endif
