#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace hoodoo {

/// A file written piece by piece, of which a reader sees the old content or the new one, never a
/// part: a temporary beside it, then fsync and rename. Folders are made as needed; what is not
/// committed is gone with its writer.
/// Errors of all members: io, not_found, naming the file.
class FileWriter {
 public:
  explicit FileWriter(std::filesystem::path path);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  /// The bytes of one number or of a plain struct.
  template <class Value>
  void put(const Value& value) {
    write(std::as_bytes(std::span(&value, 1)));
  }
  /// Where the next byte goes.
  std::uint64_t position() const { return position_; }
  /// Goes there, back or on; what is left out reads as zeros.
  void seek(std::uint64_t position);
  /// Puts all of it on the disk: no room is needed after that.
  void sync();
  void commit();
  /// Does not wait for the disk: where the power fails soon after, the file may come back empty.
  /// For what is known when damaged, and can be made again.
  void commit_unsynced();
  /// The temporary, for a library that writes by name: before `commit`, and instead of `write`.
  const std::filesystem::path& temporary() const { return part_; }

 private:
  void flush();
  void pass_on(std::span<const std::byte> bytes);
  [[noreturn]] void fail(std::string_view doing) const;

  std::filesystem::path path_, part_;
  int file_ = -1;
  std::uint64_t position_ = 0;  // with what waits
  std::vector<std::byte> waiting_;
};

}  // namespace hoodoo
