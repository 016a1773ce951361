#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "engine/dem/dem.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {

/// Bakes one tile from its slice alone: field -> Hermite blocks -> surface -> simplified surface
/// and skirts -> glTF bytes -> a file below `folder`, then its record. `hash` is the slice's.
/// Errors: limit, io.
tileset::Record bake_tile(const slice::Slice& slice, const Digest& hash,
                          std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
                          const std::filesystem::path& folder);

/// The record of the tile baked from a slice of this hash, if it and its file are in `folder`.
std::optional<tileset::Record> find_finished(const Digest& hash,
                                             const std::filesystem::path& folder);

/// Where a slice's record stands, relative to the bake's folder.
std::filesystem::path record_path(const Digest& hash);

}  // namespace hoodoo::bake
