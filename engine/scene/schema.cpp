#include <nlohmann/json.hpp>
#include <utility>

#include "engine/scene/operations.hpp"
#include "engine/scene/read_object.hpp"
#include "engine/scene/region.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/settings.hpp"
#include "engine/tree/type_choice.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

json reference(const char* name) { return {{"$ref", std::string("#/$defs/") + name}}; }

json array_of(json items, const char* doc) {
  return {{"type", "array"}, {"items", std::move(items)}, {"description", doc}};
}

/// "id", "material" and "region", which every operation may carry.
json common_properties() {
  auto properties = object_schema<OperationSettings>()["properties"];
  properties["region"] = reference("region");
  return properties;
}

/// "mirror" and "variants", which brushes and trees may carry, too.
json shape_properties() {
  auto properties = common_properties();
  properties["mirror"] = reference("mirror");
  properties["variants"] = reference("variants");
  return properties;
}

template <class T>
json described() {
  auto object = object_schema<T>();
  object["description"] = std::string(T::doc);
  return object;
}

/// {"op": ..., "tree": ...}.
json tree_operation() {
  auto operation = object_schema<TreeOperation>();
  operation["description"] = "Joins a tree of nodes with what is there.";
  operation["properties"]["tree"] = reference("terrain_node");
  operation["properties"].update(shape_properties());
  operation["required"].push_back("tree");
  return operation;
}

/// A generator or a brush where there is a "type", else a tree.
json operation() {
  const auto tree = tree::each_required({"op", "tree"});
  const json generated = {{"properties", {{"type", {{"enum", Types<AnyGenerator>::names()}}}}}};
  return {
      {"type", "object"},
      {"anyOf", tree::each_required({"op", "tree", "type"})},
      {"if", {{"required", {"type"}}}},
      {"then", {{"if", generated}, {"then", reference("generator")}, {"else", reference("brush")}}},
      {"else", {{"if", {{"anyOf", tree}}}, {"then", reference("operation.tree")}}}};
}

}  // namespace

json schema() {
  auto definitions = tree::node_schema();
  definitions["material"] = object_schema<MaterialSettings>();
  definitions["terrain"] = object_schema<TerrainSettings>();
  definitions["bake"] = object_schema<BakeSettings>();
  auto regions = Types<AnyRegion>::schema("region", definitions);
  regions["description"] = "Where an operation acts; by default everywhere.";
  definitions["region"] = std::move(regions);
  definitions["mirror"] = described<MirrorSettings>();
  definitions["variants"] = described<VariantSettings>();
  definitions["brush"] = Types<AnyBrush>::schema("brush", definitions, shape_properties());
  definitions["generator"] =
      Types<AnyGenerator>::schema("generator", definitions, common_properties());
  definitions["operation.tree"] = tree_operation();
  definitions["operation"] = operation();

  auto scene = object_schema<Header>();
  auto& properties = scene["properties"];
  properties["materials"] =
      array_of(reference("material"), "Rocks, by resistance; by default one grey rock.");
  properties["materials"]["minItems"] = 1;
  properties["terrains"] = array_of(reference("terrain"), "Elevations that make the bodies.");
  properties["terrains"]["minItems"] = 1;
  properties["define"] = {{"type", "object"},
                          {"additionalProperties", reference("any_node")},
                          {"description", "Trees by name, for {\"use\": name}."}};
  properties["geology"] = reference("geology_node");
  properties["operations"] =
      array_of(reference("operation"), "What is done to the bodies, one after the other.");
  properties["bake"] = reference("bake");
  scene["required"].push_back("terrains");
  scene["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  scene["title"] = "hoodoo scene";
  scene["description"] = "A terrain to bake. Lengths are in metres: x east, y north, z up.";
  scene["$defs"] = std::move(definitions);
  return scene;
}

}  // namespace hoodoo::scene
