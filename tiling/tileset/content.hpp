#pragma once
#include <filesystem>

#include "tiling/glb/glb.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::tileset {

/// A finished tile decoded, its slabs as one; `step` [m] and `wanted` as glb::read takes them.
/// Errors: not_found, io, bad_input naming the file.
glb::Decoded read_tile(const std::filesystem::path& folder, const Record& record, double step,
                       glb::Wanted wanted = glb::Wanted::all);

}  // namespace hoodoo::tileset
