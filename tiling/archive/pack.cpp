#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/archive/archive.hpp"

namespace hoodoo::archive {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t most_file_bytes = (std::uintmax_t{4} << 30) - 1;

/// Every file that tileset.json leads to, by path relative to its folder.
class Walk {
 public:
  explicit Walk(const fs::path& folder) : folder_(folder) { open("tileset.json"); }
  const std::set<fs::path>& files() const { return files_; }

 private:
  void open(const fs::path& path) {
    if (!files_.insert(path).second) return;
    const auto where = (folder_ / path).string();
    const JsonLimits limits{.bytes = 256U << 20, .depth = 64, .values = 50'000'000};
    const json document = parse_json(read_file(folder_ / path, limits.bytes), where, limits);
    if (!document.is_object() || !document.contains("root")) {
      throw Error(Fault::bad_input, where, "is no tileset");
    }
    visit(document.at("root"), path);
  }

  void visit(const json& tile, const fs::path& path) {
    const auto refuse = [&](const std::string& why) {
      return Error(Fault::bad_input, (folder_ / path).string(), why);
    };
    if (!tile.is_object()) throw refuse("has a tile that is no object");
    std::vector<json> contents;
    if (tile.contains("content")) contents.push_back(tile.at("content"));
    if (tile.contains("contents")) {
      if (!tile.at("contents").is_array()) throw refuse("has contents that are no list");
      for (const auto& content : tile.at("contents")) contents.push_back(content);
    }
    for (const auto& content : contents) {
      if (!content.is_object() || !content.contains("uri") || !content.at("uri").is_string()) {
        throw refuse("has a content without a uri");
      }
      const auto uri = content.at("uri").get<std::string>();
      const auto target = (path.parent_path() / uri).lexically_normal();
      if (target.empty() || target.is_absolute() || *target.begin() == "..") {
        throw refuse("names a file outside: " + uri);
      }
      if (target.extension() == ".json") {
        open(target);
      } else {
        files_.insert(target);
      }
    }
    if (!tile.contains("children")) return;
    for (const auto& child : tile.at("children")) visit(child, path);
  }

  const fs::path& folder_;
  std::set<fs::path> files_;
};

}  // namespace

Packing::Packing(fs::path folder) : folder_(std::move(folder)) {
  auto files = Walk(folder_).files();
  files.insert("bake.json");
  files_.assign(files.begin(), files.end());
}

std::optional<std::string> Packing::next() {
  if (packed_ == files_.size()) {
    if (std::exchange(ended_, true)) return std::nullopt;
    return records_.end();
  }
  const auto& path = files_[packed_++];
  const auto bytes = read_file(folder_ / path, most_file_bytes);
  return records_.head(path.generic_string(), std::as_bytes(std::span(bytes))) + bytes;
}

std::size_t pack(const fs::path& folder, const fs::path& file) {
  Packing packing(folder);
  FileWriter writer(file);
  while (const auto piece = packing.next()) writer.write(*piece);
  writer.commit();
  return packing.files();
}

}  // namespace hoodoo::archive
