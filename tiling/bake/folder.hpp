#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <vector>

#include "engine/base/lock.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {

/// A bake's folder in use by one run. Any number of runs, in any processes, may use one at once:
/// tiles and elevations are written whole, and nothing that is in use is swept away.
class FolderInUse {
 public:
  /// Makes the folder. Errors: io, cancelled.
  FolderInUse(std::filesystem::path folder, const std::stop_token& stop);

  /// Ends the use: runs on one folder take turns to call `gather`, which completes the records of
  /// `bake` by what others finished, and to write the index. It has measured errors when it is
  /// complete, estimates otherwise. The last of the runs removes what a complete index does not
  /// name. Errors: io, bad_input (a damaged tile), cancelled.
  void end(tileset::Bake& bake, const std::function<void()>& gather, int threads,
           const std::stop_token& stop);

 private:
  void sweep(const tileset::Bake& bake, const std::vector<std::filesystem::path>& files) const;

  std::filesystem::path folder_;
  std::unique_ptr<FileLock> use_;  // shared by all runs
};

/// Where a bake keeps elevations, relative to its folder.
std::filesystem::path elevations_path();

/// Where a slice's record stands, relative to the bake's folder.
std::filesystem::path record_path(const Digest& slice);

}  // namespace hoodoo::bake
