#pragma once
#include <filesystem>
#include <functional>
#include <vector>

namespace hoodoo::tileset {

/// Files below a bake's folder that nothing names, by relative path, sorted; what the bake keeps
/// for itself in .hoodoo is none of them. While a run is using the folder, or tiles are missing
/// (`complete` is false), nor are temporaries, tiles and external tilesets: they may be named yet.
/// Errors: io.
std::vector<std::filesystem::path> orphans(
    const std::filesystem::path& folder,
    const std::function<bool(const std::filesystem::path&)>& is_named, bool complete);

}  // namespace hoodoo::tileset
