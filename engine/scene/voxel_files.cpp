#include "engine/scene/voxel_files.hpp"

#include "engine/scene/vdb.hpp"

namespace hoodoo::scene {

std::optional<tree::Voxels> VoxelFiles::read(const std::string& file, const std::string& grid,
                                             const std::string& where) {
  if (const auto known = known_.find({file, grid}); known != known_.end()) return known->second;
  // A definition that does not fit one family of trees is read as the other.
  if (!told_.insert(where).second) return std::nullopt;
  const auto path = find_file(file, where + "/file", sources_, findings_);
  if (!path) return std::nullopt;
  auto voxels = read_vdb(*path, file, grid, where, voxels_left_, findings_);
  if (voxels) known_[{file, grid}] = *voxels;
  return voxels;
}

}  // namespace hoodoo::scene
