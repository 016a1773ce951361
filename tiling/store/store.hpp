#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/hash.hpp"

/// tiling/store: bytes by content hash -> files on disk, written atomically.
namespace hoodoo::store {

/// tiles/<first two digits>/<digest>.glb below `folder`.
std::filesystem::path tile_path(const Digest& content);  // relative

/// Writes a tile unless a file of that name and size is there already. Returns its digest.
Digest put_tile(const std::filesystem::path& folder, std::span<const std::byte> bytes);
/// A tile of another folder, as the same file where the disk can have one in two folders, else as a
/// copy. Errors: not_found, io, and bad_input when the bytes do not have that digest.
void share_tile(const std::filesystem::path& from, const std::filesystem::path& into,
                const Digest& content);
/// Errors: not_found, io, and bad_input when the bytes do not have that digest.
std::vector<std::byte> get_tile(const std::filesystem::path& folder, const Digest& content);

/// The digest in the name of a tile or of a record, which are named alike; nothing for others.
std::optional<Digest> digest_of(const std::filesystem::path& file);

/// Removes temporaries of killed runs and, below tiles, .hoodoo/tiles and .hoodoo/elevations of
/// `folder`, every file that is not to `keep`, by its path relative to the folder. Nobody else may
/// be writing to `folder`. Holds the names of one folder's files at a time.
void sweep(const std::filesystem::path& folder,
           const std::function<bool(const std::filesystem::path&)>& keep);

}  // namespace hoodoo::store
