#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <stop_token>

#include "engine/base/lock.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {

/// A bake's folder in use by one run. Any number of runs, in any processes, may use one at once:
/// tiles and elevations are written whole, and nothing that is in use is swept away.
class FolderInUse {
 public:
  /// Makes the folder. Errors: io, cancelled.
  FolderInUse(std::filesystem::path folder, const std::stop_token& stop);

  /// Ends the use: runs on one folder take turns to call `gather`, which notes in the tiles of
  /// `index` what others finished, and to write the index. It has measured errors when it is
  /// complete, estimates otherwise. The last of the runs removes what a complete index does not
  /// name; `beside` are files to keep beside the elevations.
  /// Errors: io, bad_input (a damaged tile), cancelled.
  tileset::Written end(tileset::Index& index, const std::set<std::filesystem::path>& beside,
                       const std::function<void()>& gather, int threads,
                       const std::stop_token& stop);

 private:
  void sweep(tileset::Index& index, const std::set<std::filesystem::path>& beside,
             std::vector<std::uint64_t>& slabs) const;

  std::filesystem::path folder_;
  std::unique_ptr<FileLock> use_;  // shared by all runs
};

/// Where a bake keeps elevations, relative to its folder.
std::filesystem::path elevations_path();

/// Takes elevations from the folder of another bake that `into` does not have, as the same files
/// where the disk can have one in two folders; what cannot be taken is left out. Errors: io,
/// cancelled.
void share_elevations(const std::filesystem::path& from, const std::filesystem::path& into,
                      const std::stop_token& stop);

/// The record of a finished tile in a bake's folder. Errors: not_found, io, bad_input.
tileset::Record read_record(const std::filesystem::path& folder, const Digest& slice);

/// Where a slice's record stands, relative to the bake's folder.
std::filesystem::path record_path(const Digest& slice);

}  // namespace hoodoo::bake
