#include "tiling/tileset/tree.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "engine/base/file.hpp"

namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;

/// The four keys below one, in the order of keys.
std::array<plan::Key, 4> below(const plan::Key& key) {
  const int level = key.level - 1;
  const auto x = 2 * key.x, y = 2 * key.y;
  return {{{level, x, y}, {level, x, y + 1}, {level, x + 1, y}, {level, x + 1, y + 1}}};
}

[[noreturn]] void fail(const fs::path& folder) {
  throw Error(Fault::io, folder.string(),
              "the boxes of its tiles cannot be kept: " + std::generic_category().message(errno));
}

/// A file of this folder that has no name any more.
int nameless_file(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::string name = (folder / "boxes-XXXXXX").string() + std::string(leftover_suffix);
  const int file = ::mkostemps(name.data(), static_cast<int>(leftover_suffix.size()), O_CLOEXEC);
  if (file < 0) fail(folder);
  ::unlink(name.c_str());
  return file;
}

}  // namespace

std::size_t Index::finished() const {
  return static_cast<std::size_t>(std::ranges::count(tiles, true, &plan::Tile::finished));
}

Tree::Tree(Index& index, const fs::path& folder)
    : index_(index), folder_(folder), boxes_(nameless_file(folder)) {
  try {
    for (auto& tile : index_.tiles) note(tile);  // finest level first
  } catch (...) {
    ::close(boxes_);
    throw;
  }
}
Tree::~Tree() { ::close(boxes_); }

void Tree::note(plan::Tile& tile) {
  bool all = tile.level > 0, any = false, shows = false;
  if (tile.level > 0) {
    for (const auto& key : below(tile.key())) {
      const auto* child = plan::find(std::span<const plan::Tile>(index_.tiles), key);
      if (child == nullptr) continue;  // never planned
      any = true;
      all = all && child->covered;
      shows = shows || child->shown;
    }
  }
  tile.covered = tile.finished || (any && all);
  tile.leaf = !shows || (tile.has_content() && !all);
  tile.shown = tile.has_content() || !tile.leaf;
  if (!tile.shown) return;
  Box box;
  for (const auto* child : children(tile)) box.add(this->box(*child));
  if (tile.has_content()) box.add(index_.read(tile).box);
  put(tile, box);
}

std::vector<plan::Tile*> Tree::children(const plan::Tile& tile) const {
  std::vector<plan::Tile*> found;
  if (tile.leaf) return found;
  for (const auto& key : below(tile.key())) {
    auto* child = plan::find(std::span<plan::Tile>(index_.tiles), key);
    if (child != nullptr && child->shown) found.push_back(child);
  }
  return found;
}

std::vector<const plan::Tile*> Tree::roots() const {
  std::vector<const plan::Tile*> found;
  const int top = index_.tiles.empty() ? 0 : index_.tiles.back().level;
  for (auto at = index_.tiles.rbegin(); at != index_.tiles.rend() && at->level == top; ++at) {
    if (at->shown) found.push_back(&*at);
  }
  return {found.rbegin(), found.rend()};
}

Box Tree::box(const plan::Tile& tile) const {
  Box box;
  const auto place = static_cast<off_t>(sizeof(Box)) * (&tile - index_.tiles.data());
  if (::pread(boxes_, &box, sizeof box, place) != sizeof box) fail(folder_);
  return box;
}

void Tree::put(const plan::Tile& tile, const Box& box) const {
  const auto place = static_cast<off_t>(sizeof(Box)) * (&tile - index_.tiles.data());
  if (::pwrite(boxes_, &box, sizeof box, place) != sizeof box) fail(folder_);
}

}  // namespace hoodoo::tileset
