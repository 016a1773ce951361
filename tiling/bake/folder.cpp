#include "tiling/bake/folder.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tiling/store/store.hpp"

namespace hoodoo::bake {

namespace fs = std::filesystem;

fs::path elevations_path() { return fs::path(".hoodoo") / "elevations"; }

fs::path record_path(const Digest& slice) {
  const auto hex = slice.hex();
  return fs::path(".hoodoo") / "tiles" / hex.substr(0, 2) / (hex + ".json");
}

FolderInUse::FolderInUse(fs::path folder, const std::stop_token& stop)
    : folder_(std::move(folder)),
      use_(std::make_unique<FileLock>(folder_ / ".hoodoo" / "use.lock", FileLock::Kind::shared,
                                      stop)) {}

void share_elevations(const fs::path& from, const fs::path& into, const std::stop_token& stop) {
  std::error_code error;
  for (fs::directory_iterator at(from / elevations_path(), error), end; !error && at != end;
       at.increment(error)) {
    const auto digest = Digest::parse(at->path().filename().native());
    if (!digest) continue;
    const auto place = into / elevations_path() / digest->hex();
    const FileLock lock(place.string() + ".lock", FileLock::Kind::exclusive, stop);
    if (fs::exists(place / "pyramid.json")) continue;
    const fs::path unfinished = place.string() + ".part";
    std::error_code failure;
    fs::remove_all(unfinished, failure);
    using Options = fs::copy_options;
    fs::copy(at->path(), unfinished, Options::recursive | Options::create_hard_links, failure);
    if (failure) {  // on another disk
      fs::remove_all(unfinished, failure);
      fs::copy(at->path(), unfinished, Options::recursive, failure);
    }
    // What is removed there meanwhile is made anew here.
    if (!failure && fs::exists(unfinished / "pyramid.json", failure)) {
      fs::remove_all(place, failure);
      fs::rename(unfinished, place, failure);
    }
    fs::remove_all(unfinished, failure);
  }
}

tileset::Record read_record(const fs::path& folder, const Digest& slice) {
  const auto path = folder / record_path(slice);
  const auto where = path.string();
  return tileset::record_from_json(parse_json(read_file(path, 1 << 20), where), where);
}

tileset::Written FolderInUse::end(tileset::Index& index, const std::set<fs::path>& beside,
                                  const std::function<void()>& gather, int threads,
                                  const std::stop_token& stop) {
  const FileLock turn(folder_ / ".hoodoo" / "index.lock", FileLock::Kind::exclusive, stop);
  gather();
  if (index.complete()) {
    tileset::measure_errors(index, folder_, threads, stop);
  } else {
    tileset::estimate_errors(index);
  }
  auto written = tileset::write_index(index, folder_);
  // Runs give up their use only here, in turn, so that exactly the last one finds itself alone.
  if (index.complete() && use_->make_exclusive()) sweep(index, beside, written.slabs);
  use_.reset();
  return written;
}

/// Tiles are looked for by what names their files, in their own array sorted that way.
void FolderInUse::sweep(tileset::Index& index, const std::set<fs::path>& beside,
                        std::vector<std::uint64_t>& slabs) const {
  std::set<fs::path> elevations;
  for (const auto& name : beside) elevations.insert(elevations_path() / name);
  for (const auto& digest : index.elevations) {
    elevations.insert(elevations_path() / digest.hex());
    elevations.insert(elevations_path() / (digest.hex() + ".lock"));
  }
  auto& tiles = index.tiles;
  // Keeps all but files whose path starts with `start` and is not that of a digest that is wanted.
  const auto sweep_below = [&](const std::string& start, auto path_of, auto wanted) {
    store::sweep(folder_, [&](const fs::path& file) {
      if (!file.generic_string().starts_with(start)) return true;
      const auto digest = store::digest_of(file);
      return digest && file == path_of(*digest) && wanted(*digest);
    });
  };
  std::ranges::sort(tiles, {}, &plan::Tile::slice);
  sweep_below(".hoodoo/tiles/", record_path, [&](const Digest& slice) {
    return std::ranges::binary_search(tiles, slice, {}, &plan::Tile::slice);
  });
  std::ranges::sort(tiles, {}, &plan::Tile::mark);
  std::ranges::sort(slabs);
  sweep_below("tiles/", store::tile_path, [&](const Digest& content) {
    return std::ranges::binary_search(tiles, content.start(), {}, &plan::Tile::mark) ||
           std::ranges::binary_search(slabs, content.start());
  });
  store::sweep(folder_, [&](const fs::path& file) {
    if (!file.generic_string().starts_with(".hoodoo/elevations/")) return true;
    return elevations.contains(file) || elevations.contains(file.parent_path());
  });
  std::ranges::sort(tiles, {}, &plan::Tile::key);
}

}  // namespace hoodoo::bake
