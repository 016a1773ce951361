#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.hpp"
#include "tiling/archive/archive.hpp"

/// Finished tilesets that are streamed as they are.
namespace hoodoo::http {

class Tilesets {
 public:
  Tilesets() = default;
  /// Each path is the folder of a tileset or a .3tz archive, known by the folder's name or by the
  /// archive's without its ending. An archive stays open: one that takes its place is seen when the
  /// server starts again.
  /// Errors: not_found, io; bad_input: no tileset.json, a name that no URL can have as it is, or
  /// two of one name.
  explicit Tilesets(std::span<const std::filesystem::path> paths);

  std::vector<std::string> names() const;
  /// None when there is no such tileset, or it is an archive.
  std::optional<std::filesystem::path> folder(std::string_view name) const;
  /// `file` of the tileset `name`, as `serve_file` would.
  Response serve(std::string_view name, std::string_view file, const Request& request) const;

 private:
  struct Tileset {
    std::filesystem::path folder;
    std::shared_ptr<const archive::Archive> archive;  // instead of the folder
  };
  std::map<std::string, Tileset, std::less<>> tilesets_;
};

}  // namespace hoodoo::http
