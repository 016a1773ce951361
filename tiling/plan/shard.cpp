#include <algorithm>
#include <charconv>

#include "tiling/plan/plan.hpp"

namespace hoodoo::plan {
namespace {

/// Where a tile's first corner stands at level 0, as an unsigned number of the same order.
std::uint64_t corner(std::int64_t index, int level) {
  return (static_cast<std::uint64_t>(index) << level) ^ (std::uint64_t{1} << 63);
}

/// The highest bit set in `a` is below that of `b`.
bool lower_top(std::uint64_t a, std::uint64_t b) { return a < b && a < (a ^ b); }

/// Order on the curve without interleaving bits: the axis that differs in the highest bit decides.
bool before(const Key& a, const Key& b) {
  const auto ax = corner(a.x, a.level), bx = corner(b.x, b.level);
  const auto ay = corner(a.y, a.level), by = corner(b.y, b.level);
  if (ax == bx && ay == by) return a.level > b.level;
  return lower_top(ay ^ by, ax ^ bx) ? ax < bx : ay < by;
}

}  // namespace

std::optional<Shard> Shard::parse(std::string_view text) {
  Shard shard;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](std::int64_t& value) {
    const auto result = std::from_chars(at, end, value);
    at = result.ptr;
    return result.ec == std::errc();
  };
  if (!number(shard.index) || at == end || *at++ != '/' || !number(shard.count) || at != end ||
      shard.count > most || shard.index < 1 || shard.index > shard.count) {
    return std::nullopt;
  }
  return shard;
}

void sort_along_curve(std::span<Tile> tiles) {
  std::sort(tiles.begin(), tiles.end(),
            [](const Tile& a, const Tile& b) { return before(a.key(), b.key()); });
}

void choose(const Shard& shard, std::span<Tile> tiles) {
  sort_along_curve(tiles);
  const auto size = static_cast<std::int64_t>(tiles.size());
  const auto first = (shard.index - 1) * size / shard.count;
  const auto last = shard.index * size / shard.count;
  for (std::int64_t i = 0; i < size; ++i) {
    tiles[static_cast<std::size_t>(i)].ours = i >= first && i < last;
  }
  std::ranges::sort(tiles, {}, &Tile::key);
}

}  // namespace hoodoo::plan
