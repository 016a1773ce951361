#include "tiling/compare/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/content.hpp"

namespace hoodoo::compare {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_held = 12;
constexpr std::size_t most_problems = 20;

tileset::Manifest finished_bake(const fs::path& folder) {
  tileset::expect_bake(folder);
  auto manifest = tileset::read_manifest(folder);
  if (!manifest.complete) {
    throw Error(Fault::bad_input, folder.string(), "holds a bake that is not finished");
  }
  return manifest;
}

}  // namespace

Surfaces::Surfaces(const fs::path& folder)
    : folder_(folder), manifest_(finished_bake(folder)), earth_(dem::earth_of(manifest_.frame)) {
  for (auto& record : manifest_.records) {
    if (earth_ && !record.empty) record.box = glb::scene_box(record.box, *earth_);
    if (!record.empty) tiles_.emplace(record.key, &record);
  }
  check_files();
}

void Surfaces::check_files() const {
  std::vector<Problem> problems;
  std::size_t count = 0;
  const auto blame = [&](const fs::path& file, std::string what) {
    if (++count <= most_problems) problems.push_back({file.string(), std::move(what)});
  };
  for (const auto& [key, record] : tiles_) {
    for (const auto& part : record->files()) {
      const auto file = folder_ / store::tile_path(part.content);
      std::error_code error;
      const auto size = fs::file_size(file, error);
      if (error) {
        blame(file, fmt::format("tile {} is missing: {}", key.text(), error.message()));
      } else if (size != part.bytes) {
        blame(file, fmt::format("tile {} is damaged: it has {} bytes, not {}", key.text(), size,
                                part.bytes));
      }
    }
  }
  if (count > most_problems) {
    problems.push_back({folder_.string(), fmt::format("and {} more", count - most_problems)});
  }
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
}

Box Surfaces::area(const plan::Key& key) const {
  const Box area = manifest_.lattice.area(key);
  return {area.min + shift_, area.max + shift_};
}

Box Surfaces::bounds(const plan::Key& key) const {
  const Box& box = tiles_.at(key)->box;
  return {box.min + shift_, box.max + shift_};
}

std::vector<plan::Key> Surfaces::lattice_over(const Box& area, int level) const {
  const double side = manifest_.lattice.spacing(level) * manifest_.lattice.tile_cells;
  const auto first = [&](double low) { return static_cast<std::int64_t>(std::floor(low / side)); };
  const auto last = [&](double high) {
    return static_cast<std::int64_t>(std::ceil(high / side)) - 1;
  };
  std::vector<plan::Key> keys;
  for (auto x = first(area.min.x - shift_.x); x <= last(area.max.x - shift_.x); ++x) {
    for (auto y = first(area.min.y - shift_.y); y <= last(area.max.y - shift_.y); ++y) {
      keys.push_back({level, x, y});
    }
  }
  return keys;
}

std::vector<plan::Key> Surfaces::over(const Box& area, int level) const {
  auto keys = lattice_over(area, level);
  std::erase_if(keys, [this](const plan::Key& key) { return !tiles_.contains(key); });
  return keys;
}

std::shared_ptr<const Sheet> Surfaces::sheet(const plan::Key& key) {
  auto& held = held_[key];
  held.used = ++clock_;
  if (held.sheet) return held.sheet;
  const auto sheet = held.sheet = load(*tiles_.at(key));
  ++read_;
  if (held_.size() > most_held) {
    held_.erase(
        std::ranges::min_element(held_, {}, [](const auto& entry) { return entry.second.used; }));
  }
  return sheet;
}

std::shared_ptr<const Sheet> Surfaces::load(const tileset::Record& record) const {
  const auto where = fmt::format("{}: tile {}", folder_.string(), record.key.text());
  const double step = manifest_.lattice.step(record.key.level);
  auto tile = tileset::read_tile(folder_, record, earth_ ? step / glb::finer : step);
  if (earth_) tile = glb::from_earth(tile, *earth_, step, where);
  if (tile.surface.triangles.empty()) {
    throw Error(Fault::bad_input, where, "has no surface");
  }
  for (const auto id : tile.surface.materials) {
    if (id >= manifest_.materials.size()) {
      throw Error(Fault::bad_input, where, "has a material that bake.json does not name");
    }
  }
  tileset::Patch patch;
  tileset::add(patch, tile, -shift_);
  const double side = 3 * manifest_.lattice.spacing(record.key.level);
  lod::Buckets buckets(patch.points, patch.triangles, side);
  std::set<int> present(tile.surface.materials.begin(), tile.surface.materials.end());
  return std::make_shared<const Sheet>(Sheet{std::move(patch), std::move(tile.surface.normals),
                                             std::move(tile.surface.materials), std::move(present),
                                             std::move(buckets)});
}

}  // namespace hoodoo::compare
