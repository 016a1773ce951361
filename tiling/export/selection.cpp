#include "tiling/export/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "engine/base/error.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/tileset/content.hpp"
#include "tiling/tileset/manifest.hpp"

namespace hoodoo::exporting {
namespace {

tileset::Bake finished_bake(const std::filesystem::path& folder) {
  tileset::expect_bake(folder);
  auto bake = tileset::read_bake(folder);
  if (!bake.complete()) {
    throw Error(Fault::bad_input, folder.string(), "holds a bake that is not finished");
  }
  return bake;
}

/// Half-open as the tiles are, so that a region ending where a tile begins leaves it out.
bool touches(const Region& region, const Box& area) {
  return region.west < area.max.x && region.east > area.min.x && region.south < area.max.y &&
         region.north > area.min.y;
}

}  // namespace

Selection::Selection(const std::filesystem::path& folder, const Settings& settings)
    : folder_(folder),
      level_(settings.level),
      bake_(finished_bake(folder)),
      earth_(dem::earth_of(bake_.frame)) {
  if (level_ < 0 || level_ >= bake_.levels) {
    throw Error(Fault::bad_input, "--level",
                fmt::format("must be in [0, {}], the levels of {}, got {}", bake_.levels - 1,
                            folder.string(), level_));
  }
  Box world;
  for (auto& record : bake_.records) {
    if (record.empty || record.key.level != level_) continue;
    if (earth_) record.box = box_in_scene(record);
    world.add(record.box);
    if (!settings.region || touches(*settings.region, bake_.lattice.area(record.key))) {
      tiles_.push_back(&record);
    }
  }
  if (world.empty()) {
    throw Error(Fault::bad_input, folder.string(),
                fmt::format("has no surface at level {}", level_));
  }
  if (tiles_.empty()) {
    const auto& r = *settings.region;
    throw Error(Fault::bad_input, "--region",
                fmt::format("{},{},{},{} m has no surface of level {}, which lies within "
                            "{},{},{},{} m",
                            r.west, r.south, r.east, r.north, level_, world.min.x, world.min.y,
                            world.max.x, world.max.y));
  }
  std::ranges::sort(tiles_, {},
                    [](const tileset::Record* r) { return std::tuple(r->key.y, r->key.x); });
}

/// A tile's points lie over its own columns.
Box Selection::box_in_scene(const tileset::Record& record) const {
  Box box = bake_.lattice.area(record.key);
  const Box around = glb::scene_box(record.box, *earth_);
  box.min.z = around.min.z;
  box.max.z = around.max.z;
  return box;
}

Box Selection::box() const {
  Box box;
  for (const auto* record : tiles_) box.add(record->box);
  return box;
}

glb::Decoded Selection::read(const tileset::Record& record) const {
  const auto where = fmt::format("{}: tile {}", folder_.string(), record.key.text());
  auto tile = tileset::read_tile(folder_, record, earth_ ? step() / glb::finer : step());
  if (earth_) tile = glb::from_earth(tile, *earth_, step(), where);
  for (const auto id : tile.surface.materials) {
    if (id >= bake_.materials.size()) {
      throw Error(Fault::bad_input, where, "has a material that bake.json does not name");
    }
  }
  return tile;
}

}  // namespace hoodoo::exporting
