#include "tiling/tileset/manifest.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/store/store.hpp"

namespace hoodoo::tileset {

using nlohmann::json;

namespace {

json header(const Bake& bake) {
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
  return {{"hoodoo", 1},
          {"engine", bake.engine},
          {"name", bake.scene_name},
          {"scene", bake.scene.hex()},
          {"elevations", std::move(elevations)},
          {"complete", bake.complete()},
          {"planned", bake.planned.size()},
          {"frame", std::move(frame)},
          {"lattice",
           {{"spacing", bake.lattice.spacing0},
            {"step", bake.lattice.step0},
            {"tile_cells", bake.lattice.tile_cells}}},
          {"levels", bake.levels},
          {"materials", materials}};
}

/// Keys of the tiles that are planned but not finished.
json missing(const Bake& bake) {
  std::set<plan::Key> keys(bake.planned.begin(), bake.planned.end());
  for (const auto& record : bake.records) keys.erase(record.key);
  json list = json::array();
  for (const auto& key : keys) list.push_back(key.text());
  return list;
}

/// Keys of the tiles with a surface beside `key`, in one fixed order.
json neighbours(const plan::Key& key, const std::set<plan::Key>& present) {
  json found = json::array();
  for (std::int64_t dy = -1; dy <= 1; ++dy) {
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      const plan::Key other{key.level, key.x + dx, key.y + dy};
      if (other != key && present.contains(other)) found.push_back(other.text());
    }
  }
  return found;
}

}  // namespace

std::string manifest_text(const Bake& bake, const std::map<plan::Key, double>& errors) {
  auto records = bake.records;
  std::ranges::sort(records, {}, &Record::key);
  std::set<plan::Key> present;
  for (const auto& record : records) {
    if (!record.empty) present.insert(record.key);
  }
  std::string text = header(bake).dump(1);
  text.resize(text.size() - 2);  // the closing brace and its line
  if (!bake.complete()) text += ",\n \"missing\": " + missing(bake).dump();
  text += ",\n \"tiles\": [";
  const char* before = "\n  ";
  for (const auto& record : records) {
    json line = to_json(record);
    if (!record.empty) {
      const auto error = errors.find(record.key);
      line["geometricError"] = error == errors.end() ? 0.0 : error->second;
      line["uri"] = store::tile_path(record.content).generic_string();
      line["neighbours"] = neighbours(record.key, present);
    }
    text += before + line.dump();
    before = ",\n  ";
  }
  return text + "\n ]\n}\n";
}

namespace {

dem::Frame frame_of(const json& object, const std::string& where) {
  dem::Frame frame;
  frame.crs = text_of(object, "crs", where);
  frame.unit = number_of(object, "unit", where);
  const json origin = object.value("origin", json());
  if (!origin.is_array() || origin.size() != 2 || !origin[0].is_number() ||
      !origin[1].is_number()) {
    throw Error(Fault::bad_input, where, "must have two numbers as \"origin\"");
  }
  frame.origin_x = origin[0].get<double>();
  frame.origin_y = origin[1].get<double>();
  if (object.contains("vertical")) frame.vertical = text_of(object, "vertical", where);
  return frame;
}

}  // namespace

void expect_bake(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    throw Error(Fault::not_found, folder.string(), "is no folder");
  }
  if (!std::filesystem::exists(folder / "bake.json", error)) {
    const bool begun = std::filesystem::exists(folder / ".hoodoo", error);
    throw Error(Fault::bad_input, folder.string(),
                begun ? "holds a bake that is not finished: it has no bake.json"
                      : "holds no bake: it has no bake.json");
  }
}

json read_index(const std::filesystem::path& folder) {
  const auto file = folder / "bake.json";
  const JsonLimits limits{.bytes = std::size_t{8} << 30, .depth = 16, .values = 400'000'000};
  return parse_json(read_file(file, limits.bytes), file.string(), limits);
}

Manifest read_manifest(const std::filesystem::path& folder) {
  return manifest_from(read_index(folder), (folder / "bake.json").string());
}

Manifest manifest_from(const json& document, const std::string& where) {
  const auto refuse = [&](const char* why) { return Error(Fault::bad_input, where, why); };
  if (!document.is_object() || !document.contains("hoodoo") || document.at("hoodoo") != 1) {
    throw refuse("is not the index of a bake");
  }
  Manifest manifest;
  if (!document.contains("complete") || !document.at("complete").is_boolean()) {
    throw refuse("must say whether it is complete");
  }
  manifest.complete = document.at("complete").get<bool>();
  const auto levels = count_of(document, "levels", where);
  if (levels < 1 || levels > 62) throw refuse("must have 1 to 62 levels");
  manifest.levels = static_cast<int>(levels);
  const json lattice = document.value("lattice", json());
  manifest.lattice.spacing0 = number_of(lattice, "spacing", where);
  manifest.lattice.step0 = number_of(lattice, "step", where);
  const auto cells = count_of(lattice, "tile_cells", where);
  const double units = manifest.lattice.spacing0 / manifest.lattice.step0;
  if (!(manifest.lattice.step0 > 0 && units >= 1 && units <= 65536) || cells < 1 || cells > 65536) {
    throw refuse("has a lattice that cannot be");
  }
  manifest.lattice.tile_cells = static_cast<int>(cells);
  manifest.frame = frame_of(document.value("frame", json()), where);
  for (const auto& material : document.value("materials", json::array())) {
    manifest.materials.push_back(text_of(material, "name", where));
  }
  if (!document.contains("tiles") || !document.at("tiles").is_array()) {
    throw refuse("must have a list of tiles");
  }
  for (const auto& tile : document.at("tiles")) {
    auto record = record_from_json(tile, where);
    if (record.key.level < 0 || record.key.level >= manifest.levels) {
      throw refuse("has a tile of a level that it does not have");
    }
    if (!record.empty) manifest.errors[record.key] = number_of(tile, "geometricError", where);
    manifest.records.push_back(std::move(record));
  }
  std::ranges::sort(manifest.records, {}, &Record::key);
  const auto same = [](const Record& a, const Record& b) { return a.key == b.key; };
  if (std::ranges::adjacent_find(manifest.records, same) != manifest.records.end()) {
    throw refuse("lists a tile twice");
  }
  return manifest;
}

}  // namespace hoodoo::tileset
