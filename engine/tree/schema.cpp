// JSON Schema of the nodes.
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "engine/tree/parse.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::tree {
namespace {

using nlohmann::json;

std::string definition_name(std::string_view type) { return "node." + std::string(type); }

json list_of(const json& child, std::size_t least) {
  json list;
  list["type"] = "array";
  list["items"] = child;
  list["minItems"] = least;
  return list;
}

/// A node of type N whose children are of family `inner`.
template <class N>
json node_definition(const json& child) {
  json schema = fields_schema<N>();
  schema["type"] = "object";
  schema["description"] = std::string(N::doc);
  schema["additionalProperties"] = false;
  schema["properties"]["type"] = {{"const", std::string(N::type)}};
  schema["required"].push_back("type");
  for (const Slot& slot : std::span<const Slot>(N::slots)) {
    json one = slot.list ? list_of(child, slot.least) : child;
    one["description"] = std::string(slot.doc);
    schema["properties"][std::string(slot.key)] = std::move(one);
    if (slot.least > 0) schema["required"].push_back(std::string(slot.key));
  }
  return schema;
}

/// Adds a family's nodes, and the choice among them.
template <class... N>
void add_family(json& definitions, Family family, const std::string& name, std::variant<N...>*) {
  const json child{{"$ref", "#/$defs/" + name}};
  json choice = json::array({json{{"$ref", "#/$defs/use"}}});
  const auto add = [&]<class T>(const T*) {
    if (T::family != Family::any && T::family != family) return;
    // A type with children stands once per family, since they are of it, too.
    const bool twice = T::family == Family::any && !std::span<const Slot>(T::slots).empty();
    const std::string key = twice && family == Family::geology
                                ? "geology." + definition_name(T::type)
                                : definition_name(T::type);
    definitions[key] = node_definition<T>(child);
    choice.push_back({{"$ref", "#/$defs/" + key}});
  };
  (add(static_cast<const N*>(nullptr)), ...);
  definitions[name] = {{"oneOf", std::move(choice)}};
}

}  // namespace

json node_schema() {
  json definitions{{"point", point_definition()},
                   {"use",
                    {{"type", "object"},
                     {"description", "An instance of a tree that \"define\" holds."},
                     {"properties", {{"use", {{"type", "string"}}}}},
                     {"required", {"use"}},
                     {"additionalProperties", false}}}};
  add_family(definitions, Family::terrain, "terrain_node", static_cast<AnyNode*>(nullptr));
  add_family(definitions, Family::geology, "geology_node", static_cast<AnyNode*>(nullptr));
  return definitions;
}

}  // namespace hoodoo::tree
