#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/file_writer.hpp"

/// tiling/archive: the files of a tileset -> one .3tz file, and back.
///
/// Source: 3D Tiles Archive Format 1.3 (Maxar): a ZIP file whose last entry is an index by the MD5
/// of each path; PKWARE APPNOTE 6.3.9 for ZIP and its 64-bit extension.
namespace hoodoo::archive {

/// One file of an archive by its name: MD5, and where its local header starts.
struct Place {
  std::array<std::uint8_t, 16> md5{};
  std::uint64_t offset = 0;
};

/// What an archive has beside the bytes of its entries, each of which is stored as it is, without a
/// time. Same entries, same bytes. Held in memory are the names.
class Records {
 public:
  /// `start`: where the first entry goes.
  explicit Records(std::uint64_t start = 0) : position_(start) {}

  /// What goes before the bytes of an entry. `name` has forward slashes and is new.
  /// Errors: limit, from 4 GiB on.
  std::string head(const std::string& name, std::span<const std::byte> bytes);
  /// What goes after the last one: the index and the directory.
  std::string end();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc = 0, size = 0;
    std::uint64_t offset = 0;
  };
  std::string index() const;
  std::string directory() const;

  std::uint64_t position_;
  std::vector<Entry> entries_;
};

/// Writes an archive, entry by entry.
class Writer {
 public:
  /// `start`: where the first entry goes; what is before it reads as zeros.
  explicit Writer(const std::filesystem::path& file, std::uint64_t start = 0);

  /// Errors: those of `Records::head`; io.
  void add(const std::string& name, std::span<const std::byte> bytes);
  /// Writes what goes after them, and puts the file in place. Nothing can be added then.
  void finish();

 private:
  FileWriter file_;
  Records records_;
};

/// An archive to read from, of which 24 bytes per entry are in memory. May be used from any thread.
class Archive {
 public:
  /// Errors: not_found, io; bad_input, when the file is no such archive or has no tileset.json that
  /// is stored.
  explicit Archive(const std::filesystem::path& file);

  /// An entry's bytes in the file.
  struct Part {
    std::uint64_t offset = 0, length = 0;
    std::uint32_t crc = 0;
  };
  /// Nothing, where there is no such entry. Errors: io; bad_input, when it is compressed or the
  /// file is damaged there.
  std::optional<Part> find(std::string_view name) const;
  std::string read(const Part& part) const;

  std::size_t entries() const { return index_.size(); }
  const std::shared_ptr<const int>& descriptor() const { return file_; }

 private:
  struct Directory {
    std::uint64_t offset = 0, size = 0;
  };
  std::string bytes(std::uint64_t offset, std::uint64_t length) const;
  Directory find_directory() const;
  std::uint64_t find_index(const Directory& directory) const;
  std::optional<Part> entry_at(std::uint64_t offset, std::string_view name) const;

  std::filesystem::path path_;
  std::shared_ptr<const int> file_;
  std::uint64_t size_ = 0;
  std::vector<Place> index_;
};

/// The finished tileset in `folder` as an archive, piece by piece: tileset.json, every file it
/// leads to, and bake.json, by path. One tile is in memory at a time.
class Packing {
 public:
  /// Errors: not_found, io, bad_input.
  explicit Packing(std::filesystem::path folder);

  std::size_t files() const { return files_.size(); }
  /// What follows; nothing at the end. Errors: not_found, io, limit.
  std::optional<std::string> next();

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
  std::size_t packed_ = 0;
  bool ended_ = false;
  Records records_;
};

/// Puts it into a file. Returns the number of files in it. Errors: those of `Packing`.
std::size_t pack(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace hoodoo::archive
