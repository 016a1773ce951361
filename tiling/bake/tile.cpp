#include "tiling/bake/tile.hpp"

#include <nlohmann/json.hpp>
#include <optional>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/bake/folder.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/glb/slabs.hpp"
#include "tiling/lod/lod.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/store/store.hpp"
#include "tiling/surface/mesh.hpp"
#include "tiling/surface/surface.hpp"
#include "tiling/volume/volume.hpp"

namespace hoodoo::bake {
namespace {

namespace fs = std::filesystem;

void add_to_box(Box& box, const surface::Mesh& mesh, const slice::StepPoint& origin, double step) {
  for (const auto& p : mesh.points) {
    box.add(Vec3{static_cast<double>(origin[0] + p[0]) * step,
                 static_cast<double>(origin[1] + p[1]) * step,
                 static_cast<double>(origin[2] + p[2]) * step});
  }
}

/// Writes the tile's files and tells the record of them.
void write_files(const std::vector<glb::Content>& slabs, const slice::Slice& slice,
                 const dem::Earth* earth, const fs::path& folder, tileset::Record& record) {
  std::vector<tileset::Slab> files;
  for (const auto& slab : slabs) {
    std::optional<glb::Content> moved;
    const auto& content = slice.earth ? moved.emplace(glb::on_earth(slab, *earth)) : slab;
    const auto bytes = glb::write(content, slice.profile);
    tileset::Slab file;
    file.content = store::put_tile(folder, bytes);
    file.bytes = bytes.size();
    file.vertices = glb::vertices_of(bytes);
    file.triangles = content.surface.triangles.size();
    file.skirt_triangles = content.skirt.triangles.size();
    const slice::StepPoint origin{content.origin[0], content.origin[1], content.origin[2]};
    add_to_box(file.box, content.surface, origin, content.step);
    add_to_box(file.box, content.skirt, origin, content.step);
    files.push_back(file);
  }
  tileset::set_files(record, std::move(files));
}

/// After the files it names. A record that is damaged costs baking its tile again.
void write_record(const fs::path& folder, const tileset::Record& record) {
  write_file_unsynced(folder / record_path(record.slice), tileset::to_json(record).dump());
}

}  // namespace

tileset::Record bake_tile(const slice::Slice& slice, const Digest& hash,
                          std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
                          const dem::Earth* earth, const fs::path& folder) {
  tileset::Record record;
  record.key = slice.tile();
  record.slice = hash;

  slice::Land land(slice, pyramids);
  // A worker's tiles follow each other in the same memory.
  thread_local volume::Volume volume;
  thread_local surface::Workspace workspace;
  volume::sample(land, volume);
  const auto& whole = surface::extract(volume, land, workspace);
  record.empty = whole.triangles.empty();
  if (!record.empty) {
    const auto [surface, error] =
        lod::simplify(whole, slice.simplify / slice.step(), slice.lattice.units());
    record.simplification = error * slice.step();
    record.world_edges = lod::world_edges(surface);

    glb::Content content;
    content.step = slice.step();
    content.materials = slice.ground.materials;
    content.draco_speed = slice.draco_speed;
    for (std::size_t a = 0; a < 3; ++a) content.origin[a] = volume.low()[a] * slice.lattice.units();
    content.surface = surface::shade(surface, land, content.origin);
    auto skirt = surface::skirts(surface, content.surface, land, content.origin,
                                 2 * slice.lattice.spacing(slice.tile().level + 1));
    content.skirt = std::move(skirt);
    for (const auto material : surface.materials) {
      ++record.materials[content.materials[material].name];
    }
    const auto most = static_cast<std::size_t>(slice.tile_triangles);
    write_files(glb::slabs(content, skirt.hosts, most), slice, earth, folder, record);
  }
  write_record(folder, record);
  return record;
}

std::optional<tileset::Record> find_finished(const Digest& hash, const fs::path& folder) {
  const auto path = folder / record_path(hash);
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  try {
    auto record = read_record(folder, hash);
    if (record.slice != hash) return std::nullopt;
    for (const auto& file : record.files()) {
      const auto size = fs::file_size(folder / store::tile_path(file.content), error);
      if (error || size != file.bytes) return std::nullopt;
    }
    return record;
  } catch (const Error&) {
    return std::nullopt;  // a damaged record is baked again
  }
}

std::optional<tileset::Record> share_finished(const Digest& hash, const fs::path& from,
                                              const fs::path& folder) {
  const auto record = find_finished(hash, from);
  if (!record) return std::nullopt;
  try {
    for (const auto& file : record->files()) store::share_tile(from, folder, file.content);
  } catch (const Error& error) {
    if (error.fault != Fault::bad_input && error.fault != Fault::not_found) throw;
    return std::nullopt;  // damaged, or removed meanwhile
  }
  write_record(folder, *record);
  return record;
}

std::optional<tileset::Record> take_cached(const Digest& hash, const store::Cache& cache,
                                           const fs::path& folder) {
  const auto entry = cache.get(hash);
  if (!entry) return std::nullopt;
  tileset::Record record;
  try {
    const std::string where = "an entry of the cache";
    record = tileset::record_from_json(parse_json(entry->record, where), where);
  } catch (const Error&) {
    return std::nullopt;  // of a release with other records
  }
  if (record.slice != hash || record.bytes != entry->tile.size()) return std::nullopt;
  const auto files = record.files();
  std::span<const std::byte> rest = entry->tile;
  for (const auto& file : files) {
    if (file.bytes > rest.size() || file.content != sha256(rest.first(file.bytes))) {
      return std::nullopt;
    }
    rest = rest.subspan(file.bytes);
  }
  rest = entry->tile;
  for (const auto& file : files) {
    store::put_tile(folder, rest.first(file.bytes));
    rest = rest.subspan(file.bytes);
  }
  write_record(folder, record);
  return record;
}

void add_to_cache(const tileset::Record& record, const fs::path& folder, store::Cache& cache) {
  std::vector<std::byte> tile;  // its files one after another
  for (const auto& file : record.files()) {
    const auto bytes = store::get_tile(folder, file.content);
    tile.insert(tile.end(), bytes.begin(), bytes.end());
  }
  cache.put(record.slice, tileset::to_json(record).dump(), tile);
}

}  // namespace hoodoo::bake
