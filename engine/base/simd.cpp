#include "engine/base/simd.hpp"

#include <hwy/targets.h>

#include <array>
#include <bit>
#include <cstdint>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo {

void limit_simd(std::string_view name, std::string_view where) {
  if (name == "best") {
    hwy::DisableTargets(0);
    return;
  }
  constexpr std::array<std::pair<std::string_view, std::int64_t>, 3> targets{
      {{"ssse3", HWY_SSSE3}, {"sse4", HWY_SSE4}, {"avx2", HWY_AVX2}}};
  for (const auto& [known, bit] : targets) {
    if (name != known) continue;
    // Highway's better targets have lower bits.
    hwy::DisableTargets(bit - 1);
    return;
  }
  throw Error(Fault::bad_input, std::string(where),
              "must be ssse3, sse4, avx2 or best, got \"" + std::string(name) + "\"");
}

std::string simd_target() {
  const std::int64_t supported = hwy::SupportedTargets();
  return hwy::TargetName(supported & -supported);
}

}  // namespace hoodoo
