// JSON Schema of the nodes.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "engine/tree/parse.hpp"
#include "engine/tree/read_fields.hpp"
#include "engine/tree/type_choice.hpp"

namespace hoodoo::tree {
namespace {

using nlohmann::json;

std::string definition_name(std::string_view type) { return "node." + std::string(type); }

struct FamilyName {
  Family family;
  std::string_view any;     // one of its nodes
  std::string_view prefix;  // of types that stand in several families
};
/// The last is of what "define" holds, whose family shows where it is used.
constexpr std::array<FamilyName, 4> families{{{Family::terrain, "terrain_node", ""},
                                              {Family::geology, "geology_node", "geology."},
                                              {Family::distance, "distance_node", "distance."},
                                              {Family::any, "any_node", "any."}}};

json any_of(Family family) {
  const auto found = std::find_if(families.begin(), families.end(),
                                  [&](const auto& f) { return f.family == family; });
  return {{"$ref", "#/$defs/" + std::string(found->any)}};
}

json list_of(const json& child, const Slot& slot) {
  json list;
  list["type"] = "array";
  list["items"] = child;
  list["minItems"] = slot.least;
  if (slot.most < any_number) list["maxItems"] = slot.most;
  return list;
}

/// A node of type N in a tree of a family.
template <class N>
json node_definition(Family family) {
  json schema = fields_schema<N>();
  schema["type"] = "object";
  schema["description"] = std::string(N::doc);
  schema["$comment"] = "Source: " + std::string(N::cited) + ".";
  schema["additionalProperties"] = false;
  schema["properties"]["type"] = {{"const", std::string(N::type)}};
  schema["required"].push_back("type");
  if constexpr (Swarm<N>) schema["anyOf"] = each_required({"balls", "file"});
  for (const Slot& slot : std::span<const Slot>(N::slots)) {
    const json child = any_of(slot.family == Family::any ? family : slot.family);
    json one = slot.list ? list_of(child, slot) : child;
    one["description"] = std::string(slot.doc);
    schema["properties"][std::string(slot.key)] = std::move(one);
    if (slot.least > 0) schema["required"].push_back(std::string(slot.key));
  }
  return schema;
}

/// Adds a family's nodes, and the choice among them: an instance, or what "type" names.
template <class... N>
void add_family(json& definitions, const FamilyName& name, std::variant<N...>*) {
  TypeChoice choice;
  const auto add = [&]<class T>(const T*) {
    if (name.family != Family::any && !stands_in<T>(name.family)) return;
    // A type with children stands once per family, since they are of it, too.
    const bool several = T::family == Family::any && !std::span<const Slot>(T::slots).empty();
    const std::string key = (several ? std::string(name.prefix) : "") + definition_name(T::type);
    definitions[key] = node_definition<T>(T::family == Family::any ? name.family : T::family);
    choice.add(T::type, key);
  };
  (add(static_cast<const N*>(nullptr)), ...);
  definitions[std::string(name.any)] = {{"type", "object"},
                                        {"anyOf", each_required({"type", "use"})},
                                        {"if", {{"required", {"use"}}}},
                                        {"then", {{"$ref", "#/$defs/use"}}},
                                        {"else", choice.schema()}};
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
  for (const FamilyName& name : families) {
    add_family(definitions, name, static_cast<AnyNode*>(nullptr));
  }
  return definitions;
}

}  // namespace hoodoo::tree
