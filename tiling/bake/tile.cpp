#include "tiling/bake/tile.hpp"

#include <nlohmann/json.hpp>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/bake/folder.hpp"
#include "tiling/glb/earth.hpp"
#include "tiling/glb/glb.hpp"
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

void count(tileset::Record& record, const glb::Content& content) {
  record.triangles = content.surface.triangles.size();
  record.skirt_triangles = content.skirt.triangles.size();
  for (const auto& t : content.surface.triangles) {
    ++record.materials[content.materials[content.surface.materials[t[0]]].name];
  }
  slice::StepPoint origin{content.origin[0], content.origin[1], content.origin[2]};
  add_to_box(record.box, content.surface, origin, content.step);
  add_to_box(record.box, content.skirt, origin, content.step);
}

}  // namespace

tileset::Record bake_tile(const slice::Slice& slice, const Digest& hash,
                          std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
                          const dem::Earth* earth, const fs::path& folder) {
  tileset::Record record;
  record.key = slice.key;
  record.slice = hash;

  slice::Land land(slice, pyramids);
  const auto volume = volume::sample(land);
  const auto whole = surface::extract(volume, land);
  record.empty = whole.triangles.empty();
  if (!record.empty) {
    const auto [surface, error] = lod::simplify(whole, slice.simplify / slice.step());
    record.simplification = error * slice.step();
    record.world_edges = lod::world_edges(surface);

    glb::Content content;
    content.step = slice.step();
    content.materials = slice.ground.materials;
    content.draco_speed = slice.draco_speed;
    for (std::size_t a = 0; a < 3; ++a) content.origin[a] = volume.low()[a] * slice.lattice.units();
    content.surface = surface::shade(surface, land, content.origin);
    content.skirt = surface::skirts(surface, content.surface, land, content.origin,
                                    2 * slice.lattice.spacing(slice.key.level + 1));
    if (slice.earth) content = glb::on_earth(content, *earth);
    const auto bytes = glb::write(content, slice.profile);
    count(record, content);
    record.bytes = bytes.size();
    record.vertices = glb::vertices_of(bytes);
    record.content = store::put_tile(folder, bytes);
  }
  write_file(folder / record_path(hash), tileset::to_json(record).dump());
  return record;
}

std::optional<tileset::Record> find_finished(const Digest& hash, const fs::path& folder) {
  const auto path = folder / record_path(hash);
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  try {
    const auto where = path.string();
    auto record = tileset::record_from_json(parse_json(read_file(path, 1 << 20), where), where);
    if (record.slice != hash) return std::nullopt;
    if (record.empty) return record;
    const auto size = fs::file_size(folder / store::tile_path(record.content), error);
    return !error && size == record.bytes ? std::optional(std::move(record)) : std::nullopt;
  } catch (const Error&) {
    return std::nullopt;  // a damaged record is baked again
  }
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
  if (!record.empty && record.content != sha256(entry->tile)) return std::nullopt;
  if (!record.empty) store::put_tile(folder, entry->tile);
  write_file(folder / record_path(hash), tileset::to_json(record).dump());
  return record;
}

void add_to_cache(const tileset::Record& record, const fs::path& folder, store::Cache& cache) {
  std::vector<std::byte> tile;
  if (!record.empty) tile = store::get_tile(folder, record.content);
  cache.put(record.slice, tileset::to_json(record).dump(), tile);
}

}  // namespace hoodoo::bake
