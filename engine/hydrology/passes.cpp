#include <algorithm>
#include <limits>
#include <utility>

#include "engine/hydrology/basins.hpp"
#include "engine/hydrology/sets.hpp"

namespace hoodoo::hydrology {
namespace {

/// visit(pass, the lower set, the higher one), before they are joined, from the lowest pass on.
/// Source: Kruskal 1956, On the shortest spanning subtree of a graph.
template <class Visit>
void join_upward(std::vector<Pass>& passes, std::uint32_t basins, Visit visit) {
  std::ranges::sort(passes, {}, &Pass::level);
  Sets sets(basins);
  for (const auto& pass : passes) {
    const auto [low, high] = std::minmax({sets.of(pass.a), sets.of(pass.b)});
    if (low == high) continue;
    visit(pass, low, high);
    sets.join(low, high);
  }
}

}  // namespace

std::vector<float> spill_levels(std::vector<Pass>& passes, std::uint32_t basins) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::vector<float> levels(basins, infinity);
  levels[outside] = -infinity;
  // The members of each set as a ring.
  std::vector<std::uint32_t> next(basins);
  std::iota(next.begin(), next.end(), 0U);
  join_upward(passes, basins, [&](const Pass& pass, std::uint32_t low, std::uint32_t high) {
    if (low == outside) {
      std::uint32_t basin = high;
      do {
        levels[basin] = pass.level;
        basin = next[basin];
      } while (basin != high);
    } else {
      std::swap(next[low], next[high]);
    }
  });
  return levels;
}

std::vector<Pass> contracted(std::vector<Pass>& passes, std::uint32_t basins, std::uint32_t kept) {
  std::vector<Pass> result;
  // A set is named by its lowest number: by one that is kept, if it has any.
  join_upward(passes, basins, [&](const Pass& pass, std::uint32_t low, std::uint32_t high) {
    if (high < kept) result.push_back({low, high, pass.level});
  });
  return result;
}

}  // namespace hoodoo::hydrology
