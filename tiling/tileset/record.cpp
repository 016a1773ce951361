#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "tiling/tileset/manifest.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

using nlohmann::json;

namespace {

json to_json(const Box& box) {
  return {box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z};
}

/// Of the digests of slabs one after another.
Digest digest_of_all(const std::vector<Slab>& slabs) {
  std::vector<std::byte> all;
  for (const auto& slab : slabs) {
    const auto bytes = std::as_bytes(std::span(slab.content.bytes));
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  return sha256(all);
}

json to_json(const std::vector<Slab>& slabs) {
  json list = json::array();
  for (const auto& slab : slabs) {
    list.push_back({{"content", slab.content.hex()},
                    {"bytes", slab.bytes},
                    {"vertices", slab.vertices},
                    {"triangles", slab.triangles},
                    {"skirt_triangles", slab.skirt_triangles},
                    {"box", to_json(slab.box)}});
  }
  return list;
}

}  // namespace

void set_files(Record& record, std::vector<Slab> files) {
  record.bytes = record.vertices = record.triangles = record.skirt_triangles = 0;
  record.box = {};
  for (const auto& file : files) {
    record.bytes += file.bytes;
    record.vertices += file.vertices;
    record.triangles += file.triangles;
    record.skirt_triangles += file.skirt_triangles;
    record.box.add(file.box);
  }
  record.content = files.size() == 1 ? files.front().content : digest_of_all(files);
  if (files.size() > 1) record.slabs = std::move(files);
}

std::vector<Slab> Record::files() const {
  if (empty) return {};
  if (!slabs.empty()) return slabs;
  return {{content, bytes, vertices, triangles, skirt_triangles, box}};
}

json to_json(const Record& record) {
  json result{{"key", record.key.text()}, {"slice", record.slice.hex()}};
  if (record.empty) {
    result["empty"] = true;
    return result;
  }
  if (record.slabs.empty()) {
    result["content"] = record.content.hex();
  } else {
    result["contents"] = to_json(record.slabs);
  }
  result["bytes"] = record.bytes;
  result["vertices"] = record.vertices;
  result["triangles"] = record.triangles;
  result["skirt_triangles"] = record.skirt_triangles;
  result["world_edges"] = record.world_edges;
  result["box"] = to_json(record.box);
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
  const auto digest = Digest::parse(text_of(object, key, where));
  if (digest) return *digest;
  throw Error(Fault::bad_input, where,
              std::string("must have 64 hexadecimal digits as \"") + key + '"');
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

std::vector<Slab> slabs_of(const json& object, const std::string& where) {
  const auto& list = object.at("contents");
  if (!list.is_array() || list.size() < 2) {
    throw Error(Fault::bad_input, where, "must have two or more \"contents\"");
  }
  std::vector<Slab> slabs;
  for (const auto& entry : list) {
    slabs.push_back({digest_of(entry, "content", where), count_of(entry, "bytes", where),
                     count_of(entry, "vertices", where), count_of(entry, "triangles", where),
                     count_of(entry, "skirt_triangles", where), box_of(entry, where)});
  }
  return slabs;
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
  if (object.contains("contents")) {
    set_files(record, slabs_of(object, where));
  } else {
    set_files(record, {{digest_of(object, "content", where), count_of(object, "bytes", where),
                        count_of(object, "vertices", where), count_of(object, "triangles", where),
                        count_of(object, "skirt_triangles", where), box_of(object, where)}});
  }
  record.world_edges = count_of(object, "world_edges", where);
  record.simplification = number_of(object, "simplification", where);
  record.materials = histogram_of(object, where);
  return record;
}

}  // namespace hoodoo::tileset
