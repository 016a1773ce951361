#include "engine/tree/type_choice.hpp"

#include <string>

namespace hoodoo::tree {

using nlohmann::json;

void TypeChoice::add(std::string_view type, std::string_view definition) {
  const json is_type{{"properties", {{"type", {{"const", std::string(type)}}}}},
                     {"required", {"type"}}};
  branches_.push_back(
      {{"if", is_type}, {"then", {{"$ref", "#/$defs/" + std::string(definition)}}}});
  types_.push_back(std::string(type));
}

json TypeChoice::schema() const {
  return {{"properties", {{"type", {{"enum", types_}}}}}, {"allOf", branches_}};
}

json each_required(std::initializer_list<std::string_view> keys) {
  json list = json::array();
  for (const std::string_view key : keys) list.push_back({{"required", {std::string(key)}}});
  return list;
}

}  // namespace hoodoo::tree
