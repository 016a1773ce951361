#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace hoodoo {

/// The whole of a file. Errors: not_found, io; limit when it is longer than `most` bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t most);

/// What tells, without reading it, that a file was written to or another was put in its place.
struct FileState {
  std::uint64_t device = 0, file = 0, bytes = 0;
  std::int64_t seconds = 0, nanoseconds = 0;  // of the last change of its bytes
  friend bool operator==(const FileState&, const FileState&) = default;
};
/// Nothing when there is no such file, or none that may be looked at.
std::optional<FileState> file_state(const std::filesystem::path& path);

/// Puts `bytes` at `path` so that a reader sees the old file or the new one, never a part:
/// a temporary beside it, fsync, rename. Folders are made as needed. Errors: io.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
/// The same without fsync, as FileWriter::commit_unsynced.
void write_file_unsynced(const std::filesystem::path& path, std::string_view text);

/// True for a temporary that `write_file` or a FileWriter leaves when its process is killed.
inline constexpr std::string_view leftover_suffix = ".part";
bool is_leftover(const std::filesystem::path& path);

}  // namespace hoodoo
