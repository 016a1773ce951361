#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

using nlohmann::json;

json to_json(const Record& record) {
  json result{{"key", record.key.text()}, {"slice", record.slice.hex()}};
  if (record.empty) {
    result["empty"] = true;
    return result;
  }
  const auto& [low, high] = record.box;
  result["content"] = record.content.hex();
  result["bytes"] = record.bytes;
  result["vertices"] = record.vertices;
  result["triangles"] = record.triangles;
  result["skirt_triangles"] = record.skirt_triangles;
  result["world_edges"] = record.world_edges;
  result["box"] = {low.x, low.y, low.z, high.x, high.y, high.z};
  result["simplification"] = record.simplification;
  result["materials"] = record.materials;
  return result;
}

std::string text_of(const json& object, const char* key, const std::string& where) {
  if (!object.is_object() || !object.contains(key) || !object.at(key).is_string()) {
    throw Error(Fault::bad_input, where, std::string("must have a text \"") + key + '"');
  }
  return object.at(key).get<std::string>();
}

std::uint64_t count_of(const json& object, const char* key, const std::string& where) {
  if (!object.is_object() || !object.contains(key) || !object.at(key).is_number_unsigned()) {
    throw Error(Fault::bad_input, where, std::string("must have a count \"") + key + '"');
  }
  return object.at(key).get<std::uint64_t>();
}

double number_of(const json& object, const char* key, const std::string& where) {
  if (!object.is_object() || !object.contains(key) || !object.at(key).is_number()) {
    throw Error(Fault::bad_input, where, std::string("must have a number \"") + key + '"');
  }
  return object.at(key).get<double>();
}

Digest digest_of(const json& object, const char* key, const std::string& where) {
  const std::string hex = text_of(object, key, where);
  Digest digest;
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (hex.size() != 64 || !std::ranges::all_of(hex, is_digit)) {
    throw Error(Fault::bad_input, where,
                std::string("must have 64 hexadecimal digits as \"") + key + '"');
  }
  for (std::size_t i = 0; i < 32; ++i) {
    digest.bytes[i] = static_cast<std::uint8_t>(16 * value(hex[2 * i]) + value(hex[2 * i + 1]));
  }
  return digest;
}

namespace {

Box box_of(const json& object, const std::string& where) {
  const auto refuse = [&] {
    return Error(Fault::bad_input, where, "must have six numbers as \"box\", minima first");
  };
  if (!object.contains("box")) throw refuse();
  const auto& numbers = object.at("box");
  if (!numbers.is_array() || numbers.size() != 6) throw refuse();
  double value[6];
  for (std::size_t i = 0; i < 6; ++i) {
    if (!numbers.at(i).is_number()) throw refuse();
    value[i] = numbers.at(i).get<double>();
  }
  const Box box{{value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
  if (box.empty()) throw refuse();
  return box;
}

std::map<std::string, std::uint64_t> histogram_of(const json& object, const std::string& where) {
  if (!object.contains("materials") || !object.at("materials").is_object()) {
    throw Error(Fault::bad_input, where, "must have an object \"materials\"");
  }
  const auto& entries = object.at("materials");
  std::map<std::string, std::uint64_t> histogram;
  for (const auto& [name, count] : entries.items()) {
    histogram[name] = count_of(entries, name.c_str(), where);
  }
  return histogram;
}

}  // namespace

Record record_from_json(const json& object, const std::string& where) {
  Record record;
  const auto key = plan::Key::parse(text_of(object, "key", where));
  if (!key) throw Error(Fault::bad_input, where, "must have L/X/Y as \"key\"");
  record.key = *key;
  record.slice = digest_of(object, "slice", where);
  record.empty = object.contains("empty");
  if (record.empty) return record;
  record.content = digest_of(object, "content", where);
  record.bytes = count_of(object, "bytes", where);
  record.vertices = count_of(object, "vertices", where);
  record.triangles = count_of(object, "triangles", where);
  record.skirt_triangles = count_of(object, "skirt_triangles", where);
  record.world_edges = count_of(object, "world_edges", where);
  record.box = box_of(object, where);
  record.simplification = number_of(object, "simplification", where);
  record.materials = histogram_of(object, where);
  return record;
}

}  // namespace hoodoo::tileset
