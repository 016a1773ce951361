#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/base/json.hpp"
#include "tiling/tileset/manifest.hpp"

namespace hoodoo::tileset {

using nlohmann::json;

namespace {

dem::Frame frame_of(const json& object, const std::string& where) {
  dem::Frame frame;
  frame.crs = text_of(object, "crs", where);
  frame.unit = number_of(object, "unit", where);
  const json origin = object.value("origin", json());
  if (!origin.is_array() || origin.size() != 2 || !origin[0].is_number() ||
      !origin[1].is_number()) {
    throw Error(Fault::bad_input, where, "must have two numbers as \"origin\"");
  }
  frame.origin_x = origin[0].get<double>();
  frame.origin_y = origin[1].get<double>();
  if (object.contains("vertical")) frame.vertical = text_of(object, "vertical", where);
  return frame;
}

std::vector<int> finer_of(const json& lattice, const std::string& where) {
  std::vector<int> finer;
  if (!lattice.contains("finer")) return finer;
  for (const auto& by : lattice.at("finer")) {
    if (!by.is_number_unsigned() ||
        by.get<std::uint64_t>() > std::min<std::size_t>(finer.size(), 2)) {
      throw Error(Fault::bad_input, where, "has a \"finer\" that is no list of 0, 1 and 2");
    }
    finer.push_back(by.get<int>());
  }
  return finer;
}

ManifestHeader header_of(const json& document, const std::string& where) {
  const auto refuse = [&](const char* why) { return Error(Fault::bad_input, where, why); };
  if (!document.contains("hoodoo") || document.at("hoodoo") != 1) {
    throw refuse("is not the index of a bake");
  }
  ManifestHeader header;
  if (!document.contains("complete") || !document.at("complete").is_boolean()) {
    throw refuse("must say whether it is complete");
  }
  header.complete = document.at("complete").get<bool>();
  const auto levels = count_of(document, "levels", where);
  if (levels < 1 || levels > 62) throw refuse("must have 1 to 62 levels");
  header.levels = static_cast<int>(levels);
  const json lattice = document.value("lattice", json());
  header.lattice.spacing0 = number_of(lattice, "spacing", where);
  header.lattice.step0 = number_of(lattice, "step", where);
  const auto cells = count_of(lattice, "tile_cells", where);
  const double units = header.lattice.spacing0 / header.lattice.step0;
  if (!(header.lattice.step0 > 0 && units >= 1 && units <= 65536) || cells < 1 || cells > 65536) {
    throw refuse("has a lattice that cannot be");
  }
  header.lattice.tile_cells = static_cast<int>(cells);
  header.lattice.finer = finer_of(lattice, where);
  header.frame = frame_of(document.value("frame", json()), where);
  for (const auto& material : document.value("materials", json::array())) {
    header.materials.push_back(text_of(material, "name", where));
  }
  return header;
}

constexpr std::size_t most_member = std::size_t{1} << 30, most_entry = std::size_t{1} << 20;
constexpr JsonLimits header_limits{.bytes = most_member, .depth = 16, .values = 100'000'000};

}  // namespace

void expect_bake(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    throw Error(Fault::not_found, folder.string(), "is no folder");
  }
  if (!std::filesystem::exists(folder / "bake.json", error)) {
    const bool begun = std::filesystem::exists(folder / ".hoodoo", error);
    throw Error(Fault::bad_input, folder.string(),
                begun ? "holds a bake that is not finished: it has no bake.json"
                      : "holds no bake: it has no bake.json");
  }
}

ManifestReader::ManifestReader(const std::filesystem::path& folder)
    : stream_(folder / "bake.json") {
  read_document();
  header_ = header_of(document_, stream_.where());
  if (lines_ && (!document_.contains("format") || document_.at("format") != 2)) {
    throw Error(Fault::bad_input, stream_.where(), "must have a list of tiles");
  }
  if (!lines_) list_missing();
}

/// The first object, but for its tiles; then stands where the tiles begin.
void ManifestReader::read_document() {
  if (stream_.next() != '{') {
    throw Error(Fault::bad_input, stream_.where(), "is not the index of a bake");
  }
  stream_.take('{');
  std::string text = "{";
  std::uint64_t tiles = 0;
  while (stream_.next() != '}') {
    if (text.size() > 1 || tiles != 0) stream_.take(',');
    const auto key = stream_.value(most_entry);
    stream_.take(':');
    if (tiles == 0 && key == "\"tiles\"" && stream_.next() == '[') {
      tiles = stream_.position() + 1;
      stream_.skip_value();
    } else {
      text += (text.size() > 1 ? "," : "") + key + ":" + stream_.value(most_member);
    }
  }
  stream_.take('}');
  document_ = parse_json(text + "}", stream_.where(), header_limits);
  if (document_.contains("tiles")) {
    throw Error(Fault::bad_input, stream_.where(), "must have a list of tiles");
  }
  lines_ = tiles == 0;
  if (lines_) return;
  if (stream_.next()) {
    throw Error(Fault::bad_input, stream_.where(), "goes on after its end");
  }
  stream_.seek(tiles);
}

void ManifestReader::list_missing() {
  const auto refuse = [this](const char* why) {
    return Error(Fault::bad_input, stream_.where(), why);
  };
  const auto found = document_.find("missing");
  if (found == document_.end()) return;
  if (!found->is_array()) throw refuse("must have a list \"missing\"");
  for (const auto& text : *found) {
    const auto key = text.is_string() ? plan::Key::parse(text.get<std::string>()) : std::nullopt;
    if (!key) throw refuse("must name missing tiles as L/X/Y");
    missing_.push_back(*key);
  }
  std::ranges::sort(missing_, std::greater());
}

std::optional<ManifestReader::Entry> ManifestReader::next() {
  if (!waiting_) waiting_ = next_listed();
  std::optional<Entry> entry;
  if (!missing_.empty() && (!waiting_ || missing_.back() <= waiting_->key)) {
    entry = Entry{};
    entry->key = missing_.back();
    entry->missing = true;
    missing_.pop_back();
  } else {
    std::swap(entry, waiting_);
  }
  if (!entry) return entry;
  const auto refuse = [&](const char* why) {
    return Error(Fault::bad_input, stream_.where(), why + entry->key.text());
  };
  if (entry->key.level >= header_.levels) throw refuse("has a level too many for tile ");
  if (last_ && entry->key == *last_) throw refuse("lists a tile twice: ");
  if (last_ && entry->key < *last_) throw refuse("does not list by key the tile ");
  last_ = entry->key;
  return entry;
}

/// The next that stands in the file as a tile.
std::optional<ManifestReader::Entry> ManifestReader::next_listed() {
  if (ended_) return std::nullopt;
  const auto c = stream_.next();
  ended_ = lines_ ? !c : c == ']';
  if (ended_) return std::nullopt;
  if (!lines_ && !first_) stream_.take(',');
  first_ = false;
  return read_entry();
}

ManifestReader::Entry ManifestReader::read_entry() {
  stream_.next();
  Entry entry;
  entry.at = stream_.position();
  const auto tile = parse_json(stream_.value(most_entry), stream_.where(), {.depth = 16});
  if (lines_ && tile.is_object() && tile.contains("missing")) {
    const auto key = plan::Key::parse(text_of(tile, "key", stream_.where()));
    if (!key) throw Error(Fault::bad_input, stream_.where(), "must have L/X/Y as \"key\"");
    entry.key = *key;
    entry.missing = true;
    return entry;
  }
  entry.record = record_from_json(tile, stream_.where());
  entry.key = entry.record.key;
  if (!entry.record.empty) entry.error = number_of(tile, "geometricError", stream_.where());
  return entry;
}

Record ManifestReader::record_at(std::uint64_t at) {
  const auto back = stream_.position();
  stream_.seek(at);
  auto record = read_entry().record;
  stream_.seek(back);
  return record;
}

Manifest read_manifest(const std::filesystem::path& folder) {
  ManifestReader reader(folder);
  Manifest manifest;
  static_cast<ManifestHeader&>(manifest) = reader.header();
  while (auto entry = reader.next()) {
    if (entry->missing) continue;
    if (!entry->record.empty) manifest.errors[entry->key] = entry->error;
    manifest.records.push_back(std::move(entry->record));
  }
  return manifest;
}

}  // namespace hoodoo::tileset
