#include "tiling/plan/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo::plan {
namespace {

constexpr std::int64_t most_tiles = 4'000'000;
constexpr int most_levels = 30;
/// [cells] within a tile, whose coordinates have 24 bits; on the Earth its steps are finer.
double most_relief(const scene::Scene& scene) {
  return scene.frame.vertical.empty() ? 16384 : 4096;
}

/// Tiles [low, high) of one axis that touch an open range of metres.
struct Range {
  std::int64_t low, high;
};
Range tiles_over(double from, double to, double size) {
  const auto low = static_cast<std::int64_t>(std::floor(from / size));
  const auto high = static_cast<std::int64_t>(std::ceil(to / size));
  return {low, std::max(high, low + 1)};
}

/// Refuses elevations that rise and fall too much within a tile. Chunks tell most of the time,
/// samples otherwise.
void check_relief(const dem::Pyramid& pyramid, int level, std::size_t terrain,
                  const Lattice& lattice, const Key& key, double most) {
  const Box area = lattice.area(key);
  const auto fits = [&](const Interval& h) {
    return h.high - h.low <= most * lattice.spacing(key.level);
  };
  const auto rough = pyramid.bounds(level, area);
  if (!rough || fits(*rough)) return;
  const Interval h = pyramid.window(level, area).bounds(area);
  if (fits(h)) return;
  throw Error(
      Fault::limit, fmt::format("/terrains/{}/dem", terrain),
      fmt::format("\"{}\" goes from {:.6g} to {:.6g} m within tile {}: {:.3g} cells of {} m, "
                  "the limit is {:.0f}",
                  pyramid.name(), h.low, h.high, key.text(),
                  (h.high - h.low) / lattice.spacing(key.level), lattice.spacing(key.level), most));
}

bool has_elevations(const scene::Scene& scene, const Lattice& lattice, const Key& key) {
  bool any = false;
  for (std::size_t i = 0; i < scene.pyramids.size(); ++i) {
    const auto& pyramid = *scene.pyramids[i];
    const int level = pyramid.level_for(lattice.spacing(key.level));
    if (!pyramid.bounds(level, lattice.area(key))) continue;
    any = true;
    check_relief(pyramid, level, i, lattice, key, most_relief(scene));
  }
  return any;
}

/// Which tiles of one level are planned: a bit each.
class Grid {
 public:
  Grid(const Range& x, const Range& y)
      : x_(x), y_(y), there_(static_cast<std::size_t>((x.high - x.low) * (y.high - y.low))) {}

  void add(std::int64_t x, std::int64_t y) { there_[place(x, y)] = true; }
  /// That of the level above.
  Grid above() const {
    const auto half = [](const Range& r) { return Range{r.low >> 1, ((r.high - 1) >> 1) + 1}; };
    Grid grid(half(x_), half(y_));
    visit([&](std::int64_t x, std::int64_t y) { grid.add(x >> 1, y >> 1); });
    return grid;
  }
  std::size_t count() const {
    return static_cast<std::size_t>(std::count(there_.begin(), there_.end(), true));
  }
  /// In the order of keys.
  template <class Visit>
  void visit(Visit visit) const {
    for (auto x = x_.low; x < x_.high; ++x) {
      for (auto y = y_.low; y < y_.high; ++y) {
        if (there_[place(x, y)]) visit(x, y);
      }
    }
  }

 private:
  std::size_t place(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>((x - x_.low) * (y_.high - y_.low) + y - y_.low);
  }
  Range x_, y_;
  std::vector<bool> there_;
};

/// The tiles of all levels, in memory for exactly so many.
std::vector<Tile> tiles_of(Grid leaves, int levels) {
  std::vector<Grid> grids{std::move(leaves)};
  while (static_cast<int>(grids.size()) < levels) grids.push_back(grids.back().above());
  std::size_t count = 0;
  for (const auto& grid : grids) count += grid.count();
  std::vector<Tile> tiles;
  tiles.reserve(count);
  for (int level = 0; level < levels; ++level) {
    grids[static_cast<std::size_t>(level)].visit([&](std::int64_t x, std::int64_t y) {
      tiles.push_back(Tile(Key{level, x, y}));
    });
  }
  return tiles;
}

int levels_needed(const Lattice& lattice, const Box& extent) {
  for (int level = 0; level < most_levels; ++level) {
    const double size = lattice.spacing(level) * lattice.tile_cells;
    const Range x = tiles_over(extent.min.x, extent.max.x, size);
    const Range y = tiles_over(extent.min.y, extent.max.y, size);
    if (x.high - x.low == 1 && y.high - y.low == 1) return level + 1;
  }
  throw Error(Fault::limit, "/bake/spacing",
              fmt::format("{} m over {:.0f} x {:.0f} m needs more than {} levels", lattice.spacing0,
                          extent.max.x - extent.min.x, extent.max.y - extent.min.y, most_levels));
}

}  // namespace

std::string Key::text() const { return fmt::format("{}/{}/{}", level, x, y); }

std::optional<Key> Key::parse(std::string_view text) {
  Key key;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto number = [&](auto& value) {
    const auto result = std::from_chars(at, end, value);
    at = result.ptr;
    return result.ec == std::errc();
  };
  const auto slash = [&] { return at != end && *at++ == '/'; };
  if (!number(key.level) || !slash() || !number(key.x) || !slash() || !number(key.y) || at != end ||
      key.level < 0) {
    return std::nullopt;
  }
  return key;
}

const Tile* find(std::span<const Tile> tiles, const Key& key) {
  const auto at = std::ranges::lower_bound(tiles, key, {}, &Tile::key);
  return at != tiles.end() && at->key() == key ? &*at : nullptr;
}
Tile* find(std::span<Tile> tiles, const Key& key) {
  const auto at = std::ranges::lower_bound(tiles, key, {}, &Tile::key);
  return at != tiles.end() && at->key() == key ? &*at : nullptr;
}

Box Lattice::area(const Key& key) const {
  const double size = spacing(key.level) * tile_cells;
  const auto x = static_cast<double>(key.x), y = static_cast<double>(key.y);
  return {{x * size, y * size, -Box::infinity}, {(x + 1) * size, (y + 1) * size, Box::infinity}};
}

Plan make(const scene::Scene& scene) {
  Plan plan;
  plan.lattice = {scene.spacing, dem::step_of(scene.spacing), scene.bake.tile_cells, {}};
  const Box& extent = scene.extent;
  plan.levels = scene.bake.levels > 0 ? scene.bake.levels : levels_needed(plan.lattice, extent);
  plan.lattice.finer = finer_levels(scene, plan.lattice, plan.levels);
  const double size = plan.lattice.spacing0 * plan.lattice.tile_cells;
  const Range x = tiles_over(extent.min.x, extent.max.x, size);
  const Range y = tiles_over(extent.min.y, extent.max.y, size);
  if (x.high - x.low > most_tiles / (y.high - y.low)) {
    throw Error(
        Fault::limit, "/bake/spacing",
        fmt::format("{} m over {:.0f} x {:.0f} m gives {} x {} tiles, the limit is {}",
                    plan.lattice.spacing0, extent.max.x - extent.min.x, extent.max.y - extent.min.y,
                    x.high - x.low, y.high - y.low, most_tiles));
  }
  constexpr std::int64_t farthest = std::int64_t{1} << 30;
  if (std::min(x.low, y.low) < -farthest || std::max(x.high, y.high) > farthest) {
    throw Error(Fault::limit, "/bake/spacing",
                fmt::format("{} m puts tiles farther from the origin than {} of them",
                            plan.lattice.spacing0, farthest));
  }
  Grid leaves(x, y);
  for (std::int64_t j = y.low; j < y.high; ++j) {
    for (std::int64_t i = x.low; i < x.high; ++i) {
      if (has_elevations(scene, plan.lattice, {0, i, j})) leaves.add(i, j);
    }
  }
  plan.tiles = tiles_of(std::move(leaves), plan.levels);
  return plan;
}

}  // namespace hoodoo::plan
