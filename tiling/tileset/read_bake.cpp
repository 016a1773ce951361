#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {
namespace {

using nlohmann::json;

Error refused(const std::string& where, const std::string& why) {
  return Error(Fault::bad_input, where, why);
}

/// A list of `count` numbers, or of any number of other things where `count` is 0.
const json& list_of(const json& object, const char* key, std::size_t count,
                    const std::string& where) {
  const bool is_list = object.is_object() && object.contains(key) && object.at(key).is_array();
  if (!is_list) throw refused(where, std::string("must have a list \"") + key + '"');
  const auto& list = object.at(key);
  const auto is_number = [](const json& value) { return value.is_number(); };
  if (count > 0 && (list.size() != count || !std::ranges::all_of(list, is_number))) {
    throw refused(where, fmt::format("must have {} numbers as \"{}\"", count, key));
  }
  return list;
}

tree::Material material_of(const json& object, const std::string& where) {
  tree::Material material{};
  material.name = text_of(object, "name", where);
  const auto& color = list_of(object, "color", 3, where);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = color.at(i).get<double>();
    if (!(value >= 0 && value <= 255)) throw refused(where, "must have colours in [0, 255]");
    material.color[i] = static_cast<std::uint8_t>(value);
  }
  const auto& range = list_of(object, "resistance", 2, where);
  material.low = range.at(0).get<double>();
  material.high = range.at(1).get<double>();
  material.friction = number_of(object, "friction", where);
  return material;
}

}  // namespace

Header read_header(const ManifestReader& reader, const std::string& where) {
  const auto& document = reader.document();
  Header header;
  header.engine = text_of(document, "engine", where);
  header.scene_name = text_of(document, "name", where);
  header.scene = digest_of(document, "scene", where);
  for (const auto& digest : list_of(document, "elevations", 0, where)) {
    const auto named = json::object({{"elevations", digest}});
    header.elevations.push_back(digest_of(named, "elevations", where));
  }
  header.frame = reader.header().frame;
  header.lattice = reader.header().lattice;
  header.levels = reader.header().levels;
  for (const auto& material : list_of(document, "materials", 0, where)) {
    header.materials.push_back(material_of(material, where));
  }
  return header;
}

void expect_all_planned(std::size_t tiles, const ManifestReader& reader, const std::string& where) {
  if (tiles == count_of(reader.document(), "planned", where)) return;
  throw refused(where, "does not list every tile that is planned");
}

Bake read_bake(const std::filesystem::path& folder) {
  const auto where = (folder / "bake.json").string();
  ManifestReader reader(folder);
  Bake bake;
  static_cast<Header&>(bake) = read_header(reader, where);
  while (auto entry = reader.next()) {
    bake.planned.push_back(entry->key);
    if (!entry->missing) bake.records.push_back(std::move(entry->record));
  }
  expect_all_planned(bake.planned.size(), reader, where);
  return bake;
}

}  // namespace hoodoo::tileset
