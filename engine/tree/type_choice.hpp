#pragma once
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>

namespace hoodoo::tree {

/// The JSON Schema of objects that a "type" key tells apart. Conditions rather than "oneOf", so
/// that a validator points at what is wrong inside the object, as `hoodoo check` does, and not at
/// all that it might have been.
class TypeChoice {
 public:
  /// Objects of this type follow #/$defs/<definition>.
  void add(std::string_view type, std::string_view definition);
  nlohmann::json schema() const;

 private:
  nlohmann::json types_ = nlohmann::json::array();
  nlohmann::json branches_ = nlohmann::json::array();
};

/// Schemas that each demand one of these keys, for "anyOf" and "oneOf".
nlohmann::json each_required(std::initializer_list<std::string_view> keys);

}  // namespace hoodoo::tree
