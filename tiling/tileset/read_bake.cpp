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

/// The plan: what is finished and what is missing.
std::vector<plan::Key> planned_of(const json& document, const std::vector<Record>& finished,
                                  const std::string& where) {
  std::vector<plan::Key> planned;
  for (const auto& record : finished) planned.push_back(record.key);
  if (document.contains("missing")) {
    for (const auto& text : list_of(document, "missing", 0, where)) {
      const auto key = text.is_string() ? plan::Key::parse(text.get<std::string>()) : std::nullopt;
      if (!key) throw refused(where, "must name missing tiles as L/X/Y");
      planned.push_back(*key);
    }
  }
  std::ranges::sort(planned);
  if (std::ranges::adjacent_find(planned) != planned.end()) {
    throw refused(where, "lists a tile twice");
  }
  if (planned.size() != count_of(document, "planned", where)) {
    throw refused(where, "does not list every tile that is planned");
  }
  return planned;
}

}  // namespace

Bake read_bake(const std::filesystem::path& folder) {
  const auto where = (folder / "bake.json").string();
  const auto document = read_index(folder);
  auto manifest = manifest_from(document, where);
  Bake bake;
  bake.engine = text_of(document, "engine", where);
  bake.scene_name = text_of(document, "name", where);
  bake.scene = digest_of(document, "scene", where);
  for (const auto& digest : list_of(document, "elevations", 0, where)) {
    const auto named = json::object({{"elevations", digest}});
    bake.elevations.push_back(digest_of(named, "elevations", where));
  }
  bake.frame = manifest.frame;
  bake.lattice = manifest.lattice;
  bake.levels = manifest.levels;
  bake.planned = planned_of(document, manifest.records, where);
  for (const auto& material : list_of(document, "materials", 0, where)) {
    bake.materials.push_back(material_of(material, where));
  }
  bake.records = std::move(manifest.records);
  return bake;
}

}  // namespace hoodoo::tileset
