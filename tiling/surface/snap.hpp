#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace hoodoo::surface {

/// The step nearest to `x` cells that is inside the cell: 1 to units - 1.
inline std::int32_t snap(double x, int units) {
  const double inside = std::clamp(x, 0.0, 1.0);
  return std::clamp(static_cast<std::int32_t>(inside * units + 0.5), 1, units - 1);
}

/// `at` if no point of `taken` is there; else its free neighbour inside the cell (or face) in the
/// direction of `mean` [cells], so that two sheets never share a point. With at most three taken
/// there always is one: a corner has seven neighbours, in a face three against one taken.
template <std::size_t N>
std::array<std::int32_t, N> free_point(const std::array<std::int32_t, N>& at,
                                       std::span<const std::array<std::int32_t, N>> taken,
                                       const std::array<double, N>& mean, int units) {
  const auto is_free = [&](const auto& p) {
    return std::find(taken.begin(), taken.end(), p) == taken.end();
  };
  if (is_free(at)) return at;
  auto best = at;
  double best_score = -std::numeric_limits<double>::infinity();
  constexpr int neighbours = N == 2 ? 9 : 27;
  for (int i = 0; i < neighbours; ++i) {
    auto p = at;
    double along = 0;
    int length2 = 0;
    for (std::size_t a = 0, rest = static_cast<std::size_t>(i); a < N; ++a, rest /= 3) {
      const int offset = static_cast<int>(rest % 3) - 1;
      p[a] += offset;
      along += offset * (mean[a] * units - at[a]);
      length2 += offset * offset;
    }
    const bool inside =
        std::all_of(p.begin(), p.end(), [&](auto c) { return c >= 1 && c <= units - 1; });
    if (!inside || !is_free(p)) continue;
    const double score = along / std::sqrt(static_cast<double>(length2));
    if (score > best_score) {
      best_score = score;
      best = p;
    }
  }
  return best;
}

}  // namespace hoodoo::surface
