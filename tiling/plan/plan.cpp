#include "tiling/plan/plan.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>

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

Box Lattice::area(const Key& key) const {
  const double size = spacing(key.level) * tile_cells;
  const auto x = static_cast<double>(key.x), y = static_cast<double>(key.y);
  return {{x * size, y * size, -Box::infinity}, {(x + 1) * size, (y + 1) * size, Box::infinity}};
}

Plan make(const scene::Scene& scene) {
  Plan plan;
  plan.lattice = {scene.spacing, dem::step_of(scene.spacing), scene.bake.tile_cells};
  const Box& extent = scene.extent;
  plan.levels = scene.bake.levels > 0 ? scene.bake.levels : levels_needed(plan.lattice, extent);
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
  std::set<Key> keys;
  for (std::int64_t j = y.low; j < y.high; ++j) {
    for (std::int64_t i = x.low; i < x.high; ++i) {
      Key key{0, i, j};
      if (!has_elevations(scene, plan.lattice, key)) continue;
      for (; key.level < plan.levels && keys.insert(key).second; key = key.parent()) {
      }
    }
  }
  plan.tiles.assign(keys.begin(), keys.end());
  return plan;
}

}  // namespace hoodoo::plan
