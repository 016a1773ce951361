#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace hoodoo {

/// The whole of a file. Errors: not_found, io; limit when it is longer than `most` bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t most);

/// Puts `bytes` at `path` so that a reader sees the old file or the new one, never a part:
/// a temporary beside it, fsync, rename. Folders are made as needed. Errors: io.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

/// True for a temporary that `write_file` or a FileWriter leaves when its process is killed.
inline constexpr std::string_view leftover_suffix = ".part";
bool is_leftover(const std::filesystem::path& path);

}  // namespace hoodoo
