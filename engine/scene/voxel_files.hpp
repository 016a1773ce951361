#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "engine/scene/files.hpp"
#include "engine/tree/voxels.hpp"

namespace hoodoo::scene {

/// What the grids of one scene may hold, 256 MiB: voxels, an entry of an inner node counting twice.
inline constexpr std::size_t most_voxels = std::size_t{1} << 26;

/// The grids that a scene's trees name, each read once however often it is used. What is wrong with
/// one is told at every place that names it.
class VoxelFiles {
 public:
  /// Both outlive this.
  VoxelFiles(const Sources& sources, Findings& findings) : sources_(sources), findings_(findings) {}

  /// A grid of a file for the node at `where`; none, and problems found, when it cannot be read.
  std::optional<tree::Voxels> read(const std::string& file, const std::string& grid,
                                   const std::string& where);

 private:
  const Sources& sources_;
  Findings& findings_;
  std::size_t voxels_left_ = most_voxels;
  std::map<std::pair<std::string, std::string>, tree::Voxels> known_;
  std::set<std::string> told_;  // places of problems
};

}  // namespace hoodoo::scene
