#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/file_writer.hpp"
#include "tiling/tileset/json_stream.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

/// What bake.json says of the whole, checked.
struct ManifestHeader {
  bool complete = false;
  dem::Frame frame;
  plan::Lattice lattice;
  int levels = 1;
  std::vector<std::string> materials;  // names, by the ids of the tiles
};

/// bake.json with all its records in memory, about 400 bytes a tile.
struct Manifest : ManifestHeader {
  std::vector<Record> records;         // by key
  std::map<plan::Key, double> errors;  // of tiles that are not empty
};

/// Reads bake.json tile by tile, whichever of its two forms it has: one document, or a header and
/// then one line per planned tile. Memory does not depend on how many there are.
/// Errors of all members: not_found, io, limit, bad_input naming the file.
class ManifestReader {
 public:
  struct Entry {
    plan::Key key;
    bool missing = false;  // planned, but not finished: no record
    Record record;
    double error = 0;      // geometricError [m]
    std::uint64_t at = 0;  // for `record_at`
  };

  explicit ManifestReader(const std::filesystem::path& folder);

  const ManifestHeader& header() const { return header_; }
  /// The header as it stands in the file, without tiles.
  const nlohmann::json& document() const { return document_; }
  /// The tiles by key, each once; nothing after the last.
  std::optional<Entry> next();
  /// The record of an entry met before.
  Record record_at(std::uint64_t at);

 private:
  void read_document();
  void list_missing();
  std::optional<Entry> next_listed();
  Entry read_entry();

  JsonStream stream_;
  nlohmann::json document_;
  ManifestHeader header_;
  bool lines_ = false;  // the form with lines
  bool first_ = true, ended_ = false;
  std::vector<plan::Key> missing_;  // of a document, from the last one
  std::optional<Entry> waiting_;    // read, and not yet due
  std::optional<plan::Key> last_;
};

/// Errors: not_found, bad_input, when `folder` is none or has no bake.json.
void expect_bake(const std::filesystem::path& folder);

/// Errors: not_found, io, limit, bad_input naming the file.
Manifest read_manifest(const std::filesystem::path& folder);

/// All that the header says of its bake; and that the file lists as many tiles as it says are
/// planned. Errors: bad_input naming `where`.
Header read_header(const ManifestReader& reader, const std::string& where);
void expect_all_planned(std::size_t tiles, const ManifestReader& reader, const std::string& where);

/// Writes bake.json into `file`, so that two of them compare well. Up to `settings.lines_past`
/// tiles: one document with a header, the keys of the tiles that are missing if any are, then one
/// line per finished tile. Above that JSON Lines: the header with its "format", then one line per
/// planned tile. Notes in each tile's `mark` the start of its content's digest, and sums up into
/// `written`.
void write_manifest(Index& index, const IndexSettings& settings, FileWriter& file,
                    Written& written);

/// Members of an object, checked. Errors: bad_input naming `where` and the key.
std::string text_of(const nlohmann::json& json, const char* key, const std::string& where);
std::uint64_t count_of(const nlohmann::json& json, const char* key, const std::string& where);
double number_of(const nlohmann::json& json, const char* key, const std::string& where);
Digest digest_of(const nlohmann::json& json, const char* key, const std::string& where);

}  // namespace hoodoo::tileset
