#include "server/http/tilesets.hpp"

#include "engine/base/error.hpp"
#include "server/http/files.hpp"
#include "server/http/problem.hpp"

namespace hoodoo::http {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string_view> extensions{".json", ".glb", ".subtree"};

Error refused(const fs::path& path, std::string why) {
  return {Fault::bad_input, path.string(), std::move(why)};
}

}  // namespace

Tilesets::Tilesets(std::span<const fs::path> paths) {
  for (const auto& given : paths) {
    std::error_code error;
    const auto path = fs::canonical(given, error);
    if (error) throw Error(Fault::not_found, given.string(), error.message());
    const bool is_folder = fs::is_directory(path, error);
    const auto name = (is_folder ? path.filename() : path.stem()).string();
    if (!is_plain_name(name)) {
      throw refused(given,
                    "is served by its name, which must be of letters, digits, '.', '_' and "
                    "'-' and not start with '.'");
    }
    Tileset tileset;
    if (is_folder) {
      if (!fs::is_regular_file(path / "tileset.json", error)) {
        throw refused(given, "holds no tileset.json");
      }
      tileset.folder = path;
    } else {
      tileset.archive = std::make_shared<archive::Archive>(path);
    }
    if (!tilesets_.emplace(name, std::move(tileset)).second) {
      throw refused(given, "has the name of another tileset, " + name);
    }
  }
}

std::vector<std::string> Tilesets::names() const {
  std::vector<std::string> names;
  for (const auto& tileset : tilesets_) names.push_back(tileset.first);
  return names;
}

std::optional<fs::path> Tilesets::folder(std::string_view name) const {
  const auto found = tilesets_.find(name);
  if (found == tilesets_.end() || found->second.archive) return std::nullopt;
  return found->second.folder;
}

Response Tilesets::serve(std::string_view name, std::string_view file,
                         const Request& request) const {
  const auto found = tilesets_.find(name);
  if (found == tilesets_.end()) return problem(404, "There is no such tileset.");
  const auto& [folder, archive] = found->second;
  if (!archive) return serve_file({folder, extensions}, file, request);
  try {
    const auto part = may_be_served(file, extensions) ? archive->find(file) : std::nullopt;
    if (!part) return problem(404, "There is no such file.");
    return serve_part({archive->descriptor(), part->offset, part->length}, file, request);
  } catch (const Error& error) {  // a damaged archive is no fault of who asks
    throw Error(Fault::internal, error.problems);
  }
}

}  // namespace hoodoo::http
