// The reference pages of nodes, brushes and generators, from their JSON Schema.
#include "engine/scene/reference.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/scene/scene.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

constexpr std::string_view prefix = "node.";
constexpr const char* heading = R"(# Nodes

Every type that a construction tree is made of, written by `hoodoo schema nodes`. Solid is where F > 1/2, and the
surface lies at F = 1/2; g(r) = (1 - (r/R)^2)^3 is the falloff of radius R, e an energy, t a turbulence in [0, 1], rho a
resistance in [0, 1]. Lengths are in metres, angles in degrees. Each picture is its example by `hoodoo draw`: of a
terrain tree its surface, cut open by the faces of a cube; of a geology tree its resistance, dark where soft.
)";

/// The types of a family.
std::vector<std::string> members(const json& definitions, const std::string& family) {
  return definitions[family]["else"]["properties"]["type"]["enum"];
}

std::string number(const json& v) {
  return v.is_number_float() ? fmt::format("{:g}", v.get<double>()) : v.dump();
}

/// "(0, 100]", the names of a choice, or "" where any value does.
std::string range_of(const json& field) {
  if (field.contains("enum")) {
    std::string names;
    for (const auto& name : field["enum"]) names += (names.empty() ? "" : ", ") + name.dump();
    return names;
  }
  const json& one =
      field.contains("items") && field["items"].contains("maximum") ? field["items"] : field;
  const bool open = one.contains("exclusiveMinimum");
  if (!one.contains("maximum") || (!open && !one.contains("minimum"))) return "";
  return fmt::format("{}{}, {}]", open ? "(" : "[",
                     number(one[open ? "exclusiveMinimum" : "minimum"]), number(one["maximum"]));
}

std::string unit_of(const json& field) {
  if (field.contains("x-unit")) return field["x-unit"].get<std::string>();
  if (field.value("$ref", "") == "#/$defs/point") return "m";
  if (field.contains("items")) return unit_of(field["items"]);
  return "";
}

void add_rows(const json& object, const std::string& before, std::string& text) {
  for (const auto& [key, field] : object["properties"].items()) {
    if (key == "type") continue;
    if (field.contains("properties")) {
      add_rows(field, before + key + ".", text);
      continue;
    }
    const auto& required = object["required"];
    const bool needed = std::find(required.begin(), required.end(), key) != required.end();
    const auto fallback = field.contains("default") ? field["default"].dump()
                          : needed                  ? "required"
                                                    : "";
    text += fmt::format("| `{}{}` | {} | {} | {} | {} |\n", before, key, unit_of(field),
                        range_of(field), fallback, field.value("description", ""));
  }
}

constexpr const char* tool_heading = R"(# Brushes and generators

What an operation with a "type" may be, written by `hoodoo schema tools`. A brush builds one tree. A generator looks at
the scene as the operations before it left it - its surface, its geology, the input elevations - and queues trees of its
own, which the next operation sees. Each may have an `id`, a `region` and a `material`; a brush, and an operation with a
"tree", a `mirror` and `variants`, too, which stand at the end of this page. `hoodoo generate` lists what generators
make. e is the effect of an erosion, rho the resistance of the rock, both in [0, 1]. Lengths are in metres, angles in
degrees.
)";

/// The types under "<kind>." in the scene's schema.
std::string tool_sections(const json& definitions, const std::string& kind) {
  std::string text;
  for (const auto& [name, tool] : definitions.items()) {
    if (!name.starts_with(kind + ".")) continue;
    text += fmt::format("\n## {}\n\nA {}. {}", name.substr(kind.size() + 1), kind,
                        tool.value("description", ""));
    if (tool.contains("$comment")) text += " " + tool["$comment"].get<std::string>();
    text += "\n\n| field | unit | range | default | |\n|---|---|---|---|---|\n";
    auto own = tool;
    for (const auto* common : {"id", "region", "material", "mirror", "variants"}) {
      own["properties"].erase(common);
    }
    add_rows(own, "", text);
  }
  return text;
}

/// What an operation may carry under `key`.
std::string copies_section(const json& definitions, const std::string& key) {
  auto text = fmt::format("\n## {}\n\nOf a brush or a tree. {}\n\n", key,
                          definitions[key].value("description", ""));
  text += "| field | unit | range | default | |\n|---|---|---|---|---|\n";
  add_rows(definitions[key], "", text);
  return text;
}

std::string section(const std::string& type, const json& node, const std::string& stands) {
  auto text = fmt::format("\n## {0}\n\n![{0}](nodes/{0}.png)\n\n{1}\n\nStands in {2} trees.", type,
                          node.value("description", ""), stands);
  if (node.contains("$comment")) text += " " + node["$comment"].get<std::string>();
  text += fmt::format(" Example: [nodes/{0}.json](nodes/{0}.json).\n\n", type);
  text += "| field | unit | range | default | |\n|---|---|---|---|---|\n";
  add_rows(node, "", text);
  return text;
}

}  // namespace

std::vector<NodeName> node_names() {
  const auto definitions = tree::node_schema();
  std::map<std::string, std::vector<std::string>> stands;
  for (const char* family : {"terrain", "geology", "distance"}) {
    for (const auto& type : members(definitions, family + std::string("_node"))) {
      stands[type].emplace_back(family);
    }
  }
  std::vector<NodeName> names;
  names.reserve(stands.size());
  for (auto& [type, families] : stands) names.push_back({type, std::move(families)});
  return names;
}

std::string tool_reference() {
  const auto definitions = schema()["$defs"];
  return tool_heading + tool_sections(definitions, "generator") +
         tool_sections(definitions, "brush") + copies_section(definitions, "mirror") +
         copies_section(definitions, "variants");
}

std::string node_reference() {
  const auto definitions = tree::node_schema();
  std::string text = heading;
  for (const auto& [type, families] : node_names()) {
    text += section(type, definitions[std::string(prefix) + type],
                    fmt::format("{}", fmt::join(families, ", ")));
  }
  return text;
}

}  // namespace hoodoo::scene
