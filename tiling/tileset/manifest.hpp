#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

/// bake.json as it is read back.
struct Manifest {
  bool complete = false;
  dem::Frame frame;
  plan::Lattice lattice;
  int levels = 1;
  std::vector<std::string> materials;  // names, by the ids of the tiles
  std::vector<Record> records;         // by key
  std::map<plan::Key, double> errors;  // of tiles that are not empty
};

/// Errors: not_found, bad_input, when `folder` is none or has no bake.json.
void expect_bake(const std::filesystem::path& folder);

/// Errors: not_found, io, limit, bad_input naming the file.
Manifest read_manifest(const std::filesystem::path& folder);

/// The document itself, and what a manifest is made from.
nlohmann::json read_index(const std::filesystem::path& folder);
Manifest manifest_from(const nlohmann::json& document, const std::string& where);

/// bake.json: a header, the keys of the tiles that are missing if any are, then one line per
/// finished tile, so that two of them compare well.
std::string manifest_text(const Bake& bake, const std::map<plan::Key, double>& errors);

/// Members of an object, checked. Errors: bad_input naming `where` and the key.
std::string text_of(const nlohmann::json& json, const char* key, const std::string& where);
std::uint64_t count_of(const nlohmann::json& json, const char* key, const std::string& where);
double number_of(const nlohmann::json& json, const char* key, const std::string& where);
Digest digest_of(const nlohmann::json& json, const char* key, const std::string& where);

}  // namespace hoodoo::tileset
