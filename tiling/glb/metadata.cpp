#include "tiling/glb/metadata.hpp"

#include <nlohmann/json.hpp>
#include <set>

namespace hoodoo::glb {

using nlohmann::json;

tinygltf::Value to_value(const json& source) {
  if (source.is_object()) {
    tinygltf::Value::Object object;
    for (const auto& [key, value] : source.items()) object[key] = to_value(value);
    return tinygltf::Value(std::move(object));
  }
  if (source.is_array()) {
    tinygltf::Value::Array array;
    for (const auto& value : source) array.push_back(to_value(value));
    return tinygltf::Value(std::move(array));
  }
  if (source.is_boolean()) return tinygltf::Value(source.get<bool>());
  if (source.is_number_integer()) return tinygltf::Value(source.get<int>());
  if (source.is_number()) return tinygltf::Value(source.get<double>());
  if (source.is_string()) return tinygltf::Value(source.get<std::string>());
  return {};
}

int add_view(tinygltf::Model& model, std::span<const std::byte> bytes) {
  auto& data = model.buffers.front().data;
  data.resize((data.size() + 7) / 8 * 8);
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = bytes.size();
  const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
  data.insert(data.end(), first, first + bytes.size());
  model.bufferViews.push_back(view);
  return static_cast<int>(model.bufferViews.size() - 1);
}

namespace {

json material_schema() {
  const auto property = [](const char* type, const char* component, const char* description) {
    json result{{"type", type}, {"description", description}, {"required", true}};
    if (component != nullptr) result["componentType"] = component;
    return result;
  };
  auto color = property("VEC3", "UINT8", "Base colour, sRGB");
  color["normalized"] = true;
  return {{"id", "hoodoo"},
          {"classes",
           {{"material",
             {{"name", "Material"},
              {"properties",
               {{"name", property("STRING", nullptr, "Name in the scene")},
                {"color", color},
                {"resistance", property("VEC2", "FLOAT32", "Range of resistance, in [0, 1]")},
                {"friction", property("SCALAR", "FLOAT32", "Coefficient of friction")}}}}}}}};
}

template <class Value>
int add_column(tinygltf::Model& model, const std::vector<Value>& values) {
  return add_view(model, std::as_bytes(std::span(values)));
}

}  // namespace

void add_materials(tinygltf::Model& model, const std::vector<tree::Material>& materials) {
  std::string names;
  std::vector<std::uint32_t> offsets{0};
  std::vector<std::uint8_t> colors;
  std::vector<float> resistances, frictions;
  for (const auto& material : materials) {
    names += material.name;
    offsets.push_back(static_cast<std::uint32_t>(names.size()));
    colors.insert(colors.end(), material.color.begin(), material.color.end());
    resistances.push_back(static_cast<float>(material.low));
    resistances.push_back(static_cast<float>(material.high));
    frictions.push_back(static_cast<float>(material.friction));
  }
  const int name_view = add_view(model, std::as_bytes(std::span(names)));
  const int offset_view = add_column(model, offsets);
  const int color_view = add_column(model, colors);
  const int resistance_view = add_column(model, resistances);
  const int friction_view = add_column(model, frictions);
  const json table{
      {"name", "materials"},
      {"class", "material"},
      {"count", materials.size()},
      {"properties",
       {{"name",
         {{"values", name_view}, {"stringOffsets", offset_view}, {"stringOffsetType", "UINT32"}}},
        {"color", {{"values", color_view}}},
        {"resistance", {{"values", resistance_view}}},
        {"friction", {{"values", friction_view}}}}}};
  model.extensions["EXT_structural_metadata"] =
      to_value({{"schema", material_schema()}, {"propertyTables", json::array({table})}});
  model.extensionsUsed.emplace_back("EXT_structural_metadata");
}

tinygltf::Value features(std::span<const std::uint16_t> materials) {
  const std::set<std::uint16_t> ids(materials.begin(), materials.end());
  const json set{
      {"featureCount", ids.size()}, {"attribute", 0}, {"propertyTable", 0}, {"label", "material"}};
  return to_value({{"featureIds", json::array({set})}});
}

}  // namespace hoodoo::glb
