#include "tiling/tileset/manifest.hpp"

#include <nlohmann/json.hpp>

#include "engine/base/file_writer.hpp"
#include "tiling/store/store.hpp"

namespace hoodoo::tileset {

using nlohmann::json;

namespace {

constexpr int lines_format = 2;  // of bake.json

json header(const Index& bake) {
  json materials = json::array();
  for (const auto& material : bake.materials) {
    materials.push_back({{"name", material.name},
                         {"color", material.color},
                         {"resistance", {material.low, material.high}},
                         {"friction", material.friction}});
  }
  json elevations = json::array();
  for (const auto& digest : bake.elevations) elevations.push_back(digest.hex());
  json frame{{"crs", bake.frame.crs},
             {"unit", bake.frame.unit},
             {"origin", {bake.frame.origin_x, bake.frame.origin_y}}};
  if (!bake.frame.vertical.empty()) frame["vertical"] = bake.frame.vertical;
  json lattice{{"spacing", bake.lattice.spacing0},
               {"step", bake.lattice.step0},
               {"tile_cells", bake.lattice.tile_cells}};
  if (!bake.lattice.finer.empty()) lattice["finer"] = bake.lattice.finer;
  return {{"hoodoo", 1},
          {"engine", bake.engine},
          {"name", bake.scene_name},
          {"scene", bake.scene.hex()},
          {"elevations", std::move(elevations)},
          {"complete", bake.complete()},
          {"planned", bake.tiles.size()},
          {"frame", std::move(frame)},
          {"lattice", std::move(lattice)},
          {"levels", bake.levels},
          {"materials", materials}};
}

/// Keys of the tiles that are planned but not finished.
json missing(const Index& index) {
  json list = json::array();
  for (const auto& tile : index.tiles) {
    if (!tile.finished) list.push_back(tile.key().text());
  }
  return list;
}

/// Keys of the tiles with a surface beside `key`, in one fixed order.
json neighbours(const plan::Key& key, std::span<const plan::Tile> tiles) {
  json found = json::array();
  for (std::int64_t dy = -1; dy <= 1; ++dy) {
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      const plan::Key other{key.level, key.x + dx, key.y + dy};
      const auto* tile = other == key ? nullptr : plan::find(tiles, other);
      if (tile != nullptr && tile->has_content()) found.push_back(other.text());
    }
  }
  return found;
}

/// The line of a finished tile, which is summed up.
std::string line_of(plan::Tile& tile, const Index& index, Written& written) {
  const Record record = index.read(tile);
  json line = to_json(record);
  if (!record.empty) {
    line["geometricError"] = tile.error;
    if (record.slabs.empty()) {
      line["uri"] = store::tile_path(record.content).generic_string();
    } else {
      for (std::size_t i = 0; i < record.slabs.size(); ++i) {
        const auto& content = record.slabs[i].content;
        line["contents"][i]["uri"] = store::tile_path(content).generic_string();
        written.slabs.push_back(content.start());
      }
    }
    line["neighbours"] = neighbours(record.key, index.tiles);
    tile.mark = record.content.start();
  }
  ++written.tiles;
  written.triangles += record.triangles;
  written.bytes += record.bytes;
  return line.dump();
}

}  // namespace

void write_manifest(Index& index, const IndexSettings& settings, FileWriter& file,
                    Written& written) {
  auto head = header(index);
  if (index.tiles.size() > settings.lines_past) {
    head["format"] = lines_format;
    file.write(head.dump() + "\n");
    for (auto& tile : index.tiles) {
      const json absent{{"key", tile.key().text()}, {"missing", true}};
      file.write((tile.finished ? line_of(tile, index, written) : absent.dump()) + "\n");
    }
    return;
  }
  std::string text = head.dump(1);
  text.resize(text.size() - 2);  // the closing brace and its line
  if (!index.complete()) text += ",\n \"missing\": " + missing(index).dump();
  file.write(text + ",\n \"tiles\": [");
  const char* before = "\n  ";
  for (auto& tile : index.tiles) {
    if (!tile.finished) continue;
    file.write(before + line_of(tile, index, written));
    before = ",\n  ";
  }
  file.write("\n ]\n}\n");
}

}  // namespace hoodoo::tileset
