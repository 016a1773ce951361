#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "engine/dem/dem.hpp"
#include "engine/dem/earth.hpp"
#include "tiling/slice/slice.hpp"
#include "tiling/store/cache.hpp"
#include "tiling/tileset/tileset.hpp"

namespace hoodoo::bake {

/// Bakes one tile from its slice alone: field -> Hermite blocks -> surface -> simplified surface
/// and skirts -> glTF bytes -> a file below `folder`, then its record. `hash` is the slice's;
/// `earth` that of the slice's frame, if it has one.
/// Errors: limit, io.
tileset::Record bake_tile(const slice::Slice& slice, const Digest& hash,
                          std::span<const std::shared_ptr<const dem::Pyramid>> pyramids,
                          const dem::Earth* earth, const std::filesystem::path& folder);

/// The record of the tile baked from a slice of this hash, if it and its file are in `folder`.
std::optional<tileset::Record> find_finished(const Digest& hash,
                                             const std::filesystem::path& folder);

/// The same from the folder of another bake, which then shares its files with `folder`. Errors: io.
std::optional<tileset::Record> share_finished(const Digest& hash, const std::filesystem::path& from,
                                              const std::filesystem::path& folder);

/// The same from a cache, whose tile is put into `folder`. Errors: io.
std::optional<tileset::Record> take_cached(const Digest& hash, const store::Cache& cache,
                                           const std::filesystem::path& folder);
/// Puts a finished tile of `folder` into a cache.
void add_to_cache(const tileset::Record& record, const std::filesystem::path& folder,
                  store::Cache& cache);

}  // namespace hoodoo::bake
