#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tests/tiling/lod/meshes.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/glb/slabs.hpp"
#include "tiling/lod/lod.hpp"
#include "tiling/store/store.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

inline nlohmann::json load(const std::filesystem::path& file) {
  return parse_json(read_file(file, 1U << 30), file.string());
}

/// A small bake as an index; `bake` outlives it.
inline Index index_of(const Bake& bake) {
  Index index;
  static_cast<Header&>(index) = bake;
  auto planned = bake.planned;
  std::ranges::sort(planned);
  for (const auto& key : planned) index.tiles.emplace_back(key);
  for (const auto& record : bake.records) {
    auto* tile = plan::find(std::span<plan::Tile>(index.tiles), record.key);
    tile->slice = record.slice;
    tile->finished = true;
    tile->empty = record.empty;
  }
  index.read = [&bake](const plan::Tile& tile) {
    return *std::ranges::find(bake.records, tile.key(), &Record::key);
  };
  return index;
}

inline std::map<plan::Key, double> errors_of(const Index& index) {
  std::map<plan::Key, double> errors;
  for (const auto& tile : index.tiles) errors[tile.key()] = tile.error;
  return errors;
}

inline std::map<plan::Key, double> measure_errors(const Bake& bake,
                                                  const std::filesystem::path& folder, int threads,
                                                  std::stop_token stop = {}) {
  auto index = index_of(bake);
  measure_errors(index, folder, threads, std::move(stop));
  return errors_of(index);
}
inline std::map<plan::Key, double> estimate_errors(const Bake& bake) {
  auto index = index_of(bake);
  estimate_errors(index);
  return errors_of(index);
}

/// Returns the relative paths of every file the index needs.
inline std::vector<std::filesystem::path> write_index(const Bake& bake,
                                                      const std::map<plan::Key, double>& errors,
                                                      const std::filesystem::path& folder,
                                                      const IndexSettings& settings = {}) {
  auto index = index_of(bake);
  for (auto& tile : index.tiles) tile.error = errors.at(tile.key());
  auto files = write_index(index, folder, settings).files;
  for (const auto& record : bake.records) {
    for (const auto& file : record.files()) files.push_back(store::tile_path(file.content));
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

}  // namespace hoodoo::tileset

namespace hoodoo::shapes {

/// A folder that is gone with its owner.
struct Folder {
  std::filesystem::path path;

  explicit Folder(const std::string& name)
      : path(std::filesystem::temp_directory_path() /
             ("hoodoo-" + name + "-" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

/// Hills over 2^(levels-1) x 2^(levels-1) tiles of 16 cells, every level as a finished bake has
/// it, its tiles in `folder`, without an index. `change` may alter a tile before it is written.
struct World {
  int levels = 2;
  double simplify = 0;          // [steps]
  bool strip = false;           // only the southern row of tiles
  std::size_t slab = 1U << 24;  // most triangles of a file
  std::function<void(const plan::Key&, glb::Content&)> change = [](const auto&, auto&) {};

  static constexpr int cells = 16;

  tileset::Bake make(const std::filesystem::path& folder) const {
    tileset::Bake bake;
    bake.engine = "test";
    bake.scene_name = "hills";
    bake.lattice = {.spacing0 = 1, .step0 = 1.0 / 256, .tile_cells = cells};
    bake.levels = levels;
    bake.materials = {{"shale", {141, 131, 119}, 0, 0.4, 0.6},
                      {"chalk", {240, 240, 230}, 0.4, 1, 0.8}};
    for (int level = 0; level < levels; ++level) {
      const std::int64_t side = std::int64_t{1} << (levels - 1 - level);
      for (std::int64_t x = 0; x < side; ++x) {
        const std::int64_t rows = strip ? 1 : side;
        for (std::int64_t y = 0; y < rows; ++y) {
          const auto world = static_cast<std::uint8_t>(
              (x == 0 ? surface::west : 0) | (x == side - 1 ? surface::east : 0) |
              (y == 0 ? surface::south : 0) | (y == rows - 1 ? surface::north : 0));
          bake.planned.push_back({level, x, y});
          bake.records.push_back(make_tile(bake, bake.planned.back(), world, folder));
        }
      }
    }
    return bake;
  }

 private:
  tileset::Record make_tile(const tileset::Bake& bake, const plan::Key& key, std::uint8_t world,
                            const std::filesystem::path& folder) const {
    auto surface = height_field({.side = cells,
                                 .boundary = 20.0 / (1 << key.level),
                                 .x0 = key.x * cells,
                                 .y0 = key.y * cells,
                                 .level = key.level,
                                 .world = world});
    tileset::Record record;
    record.key = key;
    record.slice = sha256(key.text());
    const auto simplified = lod::simplify(surface, simplify, units);
    record.simplification = simplified.error * bake.lattice.step(key.level);
    record.world_edges = lod::world_edges(simplified.surface);

    glb::Content content;
    content.origin = {key.x * cells * units, key.y * cells * units, 0};
    content.step = bake.lattice.step(key.level);
    content.materials = bake.materials;
    content.surface = mesh_of(simplified.surface, content.origin);
    content.skirt = skirt_of(content.surface);
    change(key, content);
    for (const auto& t : content.surface.triangles) {
      ++record.materials[bake.materials[content.surface.materials[t[0]]].name];
    }
    const std::vector<std::uint32_t> hosts(content.skirt.triangles.size());
    std::vector<tileset::Slab> files;
    for (const auto& part : glb::slabs(content, hosts, slab)) {
      files.push_back(make_file(part, folder));
    }
    tileset::set_files(record, std::move(files));
    return record;
  }

  static tileset::Slab make_file(const glb::Content& content, const std::filesystem::path& folder) {
    tileset::Slab file;
    for (const auto* mesh : {&content.surface, &content.skirt}) {
      for (const auto& p : mesh->points) {
        const auto at = [&](std::size_t a) {
          return static_cast<double>(content.origin[a] + p[a]) * content.step;
        };
        file.box.add(Vec3{at(0), at(1), at(2)});
      }
    }
    const auto bytes = glb::write(content, "draco");
    file.bytes = bytes.size();
    file.vertices = glb::vertices_of(bytes);
    file.triangles = content.surface.triangles.size();
    file.skirt_triangles = content.skirt.triangles.size();
    file.content = store::put_tile(folder, bytes);
    return file;
  }
};

}  // namespace hoodoo::shapes
