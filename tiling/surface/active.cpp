#include "tiling/surface/lanes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tiling/surface/active.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace hoodoo::surface::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void FindActive(const volume::Volume::Rows& solid, const volume::Volume::MeshedRows& meshed,
                std::uint16_t* active) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::Rebind<std::uint16_t, decltype(d)> narrow;
  const auto sixteen = hn::Set(d, 0xffffU);
  for (std::size_t z = 0; z < 16; ++z) {
    for (std::size_t y = 0; y < 16; y += hn::Lanes(d)) {
      const auto a = hn::LoadU(d, &solid[z][y]), b = hn::LoadU(d, &solid[z][y + 1]);
      const auto c = hn::LoadU(d, &solid[z + 1][y]), e = hn::LoadU(d, &solid[z + 1][y + 1]);
      const auto any = hn::Or(hn::Or(a, b), hn::Or(c, e));
      const auto all = hn::And(hn::And(a, b), hn::And(c, e));
      const auto mixed =
          hn::AndNot(hn::And(all, hn::ShiftRight<1>(all)), hn::Or(any, hn::ShiftRight<1>(any)));
      const auto counts = hn::And(hn::ShiftRight<1>(hn::LoadU(d, &meshed[y + 1])), sixteen);
      hn::StoreU(hn::TruncateTo(narrow, hn::And(mixed, counts)), narrow, active + 16 * z + y);
    }
  }
}

}  // namespace hoodoo::surface::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace hoodoo::surface {

HWY_EXPORT(FindActive);

void find_active(const volume::Volume::Rows& solid, const volume::Volume::MeshedRows& meshed,
                 std::array<std::uint16_t, 256>& active) {
  HWY_DYNAMIC_DISPATCH(FindActive)(solid, meshed, active.data());
}

}  // namespace hoodoo::surface
#endif
