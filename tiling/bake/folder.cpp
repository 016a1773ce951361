#include "tiling/bake/folder.hpp"

#include <set>

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

void FolderInUse::end(tileset::Bake& bake, const std::function<void()>& gather, int threads,
                      const std::stop_token& stop) {
  const FileLock turn(folder_ / ".hoodoo" / "index.lock", FileLock::Kind::exclusive, stop);
  gather();
  const auto errors = bake.complete() ? tileset::measure_errors(bake, folder_, threads, stop)
                                      : tileset::estimate_errors(bake);
  const auto files = tileset::write_index(bake, errors, folder_);
  // Runs give up their use only here, in turn, so that exactly the last one finds itself alone.
  if (bake.complete() && use_->make_exclusive()) sweep(bake, files);
  use_.reset();
}

void FolderInUse::sweep(const tileset::Bake& bake, const std::vector<fs::path>& files) const {
  std::set<fs::path> keep(files.begin(), files.end());
  for (const auto& record : bake.records) keep.insert(record_path(record.slice));
  for (const auto& digest : bake.elevations) {
    const auto place = elevations_path() / digest.hex();
    keep.insert(place);
    keep.insert(place.string() + ".lock");
  }
  store::sweep(folder_, keep);
}

}  // namespace hoodoo::bake
