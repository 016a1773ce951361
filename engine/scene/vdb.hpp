#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/scene/files.hpp"
#include "engine/tree/voxels.hpp"

namespace hoodoo::scene {

/// Reads a grid of single-precision numbers from an OpenVDB file (format 222 or later, by file and
/// not by stream): the one called `grid`, or the first of its type where `grid` is empty. Inactive
/// voxels of the background value are left unset.
///
/// The tree is read node by node into tree::Voxels and never held twice. `voxels_left` is lowered
/// by what it holds, an entry of an inner node counting as two voxels; a larger one is a limit,
/// found in the tree's topology before its values are read. A file that is damaged or made to harm
/// is refused.
///
/// Problems stand at `where`/file or `where`/grid and call the file `name`.
std::optional<tree::Voxels> read_vdb(const std::filesystem::path& file, const std::string& name,
                                     const std::string& grid, const std::string& where,
                                     std::size_t& voxels_left, Findings& findings);

}  // namespace hoodoo::scene
