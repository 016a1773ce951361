#include "tiling/store/store.hpp"

#include <algorithm>
#include <array>
#include <system_error>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

namespace hoodoo::store {
namespace {

namespace fs = std::filesystem;

/// Far above any tile: Draco needs about 2.5 bytes a triangle.
constexpr std::uintmax_t most_tile_bytes = std::uintmax_t{1} << 30;

/// Where a bake keeps tiles, their records and elevations; all else below its folder is somebody
/// else's.
const std::array<fs::path, 3> swept_folders{"tiles", fs::path(".hoodoo") / "tiles",
                                            fs::path(".hoodoo") / "elevations"};

bool starts_with(const fs::path& path, const fs::path& start) {
  return std::mismatch(start.begin(), start.end(), path.begin(), path.end()).first == start.end();
}

bool holds(const fs::path& file, std::span<const std::byte> bytes) {
  std::error_code error;
  if (fs::file_size(file, error) != bytes.size() || error) return false;
  const std::string there = read_file(file, most_tile_bytes);
  return std::ranges::equal(std::as_bytes(std::span(there)), bytes);
}

[[noreturn]] void fail(const fs::path& path, const std::error_code& error) {
  throw Error(Fault::io, path.string(), error.message());
}

/// Calls `visit` for every regular file below `folder`, one folder's after another's.
void for_each_file(const fs::path& folder, const std::function<void(const fs::path&)>& visit) {
  std::vector<fs::path> files, folders;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const auto status = at->symlink_status(error);
    if (fs::is_directory(status)) folders.push_back(at->path());
    if (fs::is_regular_file(status)) files.push_back(at->path());
  }
  if (error && error != std::errc::no_such_file_or_directory) fail(folder, error);
  for (const auto& file : files) visit(file);
  files = {};
  for (const auto& below : folders) for_each_file(below, visit);
}

/// Removes folders that hold nothing, or only such, below `folder`. True if all of it was.
bool remove_empty(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> below;
  bool empty = true;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->is_directory(error)) {
      below.push_back(at->path());
    } else {
      empty = false;
    }
  }
  for (const auto& child : below) {
    if (remove_empty(child)) {
      fs::remove(child, error);
    } else {
      empty = false;
    }
  }
  return empty && !error;
}

}  // namespace

fs::path tile_path(const Digest& content) {
  const std::string hex = content.hex();
  return fs::path("tiles") / hex.substr(0, 2) / (hex + ".glb");
}

Digest put_tile(const fs::path& folder, std::span<const std::byte> bytes) {
  const Digest content = sha256(bytes);
  const fs::path file = folder / tile_path(content);
  if (!holds(file, bytes)) write_file(file, bytes);
  return content;
}

void share_tile(const fs::path& from, const fs::path& into, const Digest& content) {
  const fs::path place = into / tile_path(content);
  const auto bytes = get_tile(from, content);
  std::error_code error;
  fs::create_directories(place.parent_path(), error);
  fs::create_hard_link(from / tile_path(content), place, error);
  if (error) put_tile(into, bytes);
}

std::vector<std::byte> get_tile(const fs::path& folder, const Digest& content) {
  const fs::path file = folder / tile_path(content);
  const std::string text = read_file(file, most_tile_bytes);
  const auto bytes = std::as_bytes(std::span(text));
  if (sha256(bytes) != content) {
    throw Error(Fault::bad_input, file.string(), "its content is not what its name says");
  }
  return {bytes.begin(), bytes.end()};
}

std::optional<Digest> digest_of(const fs::path& file) {
  return Digest::parse(file.stem().native());
}

void sweep(const fs::path& folder, const std::function<bool(const fs::path&)>& keep) {
  std::error_code error;
  for_each_file(folder, [&](const fs::path& file) {
    const fs::path relative = file.lexically_relative(folder);
    const bool ours =
        std::any_of(swept_folders.begin(), swept_folders.end(),
                    [&](const fs::path& swept) { return starts_with(relative, swept); });
    if (!is_leftover(file) && (!ours || keep(relative))) return;
    fs::remove(file, error);
    if (error) fail(file, error);
  });
  for (const auto& swept : swept_folders) remove_empty(folder / swept);
}

}  // namespace hoodoo::store
