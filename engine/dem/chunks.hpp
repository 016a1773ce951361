#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/dem/dem.hpp"

namespace hoodoo::dem {

/// Side of a chunk [pixels].
inline constexpr int chunk_side = 256;
inline constexpr std::size_t chunk_pixels = std::size_t{chunk_side} * chunk_side;
inline constexpr std::size_t chunk_bytes = chunk_pixels * sizeof(float);

/// What is known of a chunk without reading it.
struct ChunkFacts {
  Digest digest;            // of its bytes, little-endian floats, row by row from the south
  float low = 0, high = 0;  // of the valid pixels
  std::uint32_t valid = 0;  // how many there are; a chunk with none has no bytes on disk
};

/// Also makes every NaN the same NaN.
ChunkFacts describe_chunk(std::span<float> pixels);

/// One level: its grid and its chunks, row by row from the south-west.
struct LevelFacts {
  Pyramid::Level grid;
  std::vector<ChunkFacts> chunks;

  std::int64_t across() const { return (grid.width + chunk_side - 1) / chunk_side; }
  std::int64_t down() const { return (grid.height + chunk_side - 1) / chunk_side; }
  std::size_t index(std::int64_t column, std::int64_t row) const {
    return static_cast<std::size_t>(row * across() + column);
  }
};

/// The file of one level's chunks. Reading and writing of different chunks may go on at once.
class ChunkFile {
 public:
  enum class Mode { read, create };
  /// Errors: io.
  ChunkFile(std::filesystem::path path, Mode mode);
  ~ChunkFile();
  ChunkFile(ChunkFile&& other) noexcept;
  ChunkFile(const ChunkFile&) = delete;
  ChunkFile& operator=(const ChunkFile&) = delete;
  ChunkFile& operator=(ChunkFile&&) = delete;

  /// `pixels` of the chunk from pixel `first` on. What was never written reads as 0.
  void write(std::size_t chunk, std::size_t first, std::span<const float> pixels);
  void read(std::size_t chunk, std::span<float> pixels) const;
  /// Waits until everything written is on the disk.
  void sync();

 private:
  std::filesystem::path path_;
  int fd_ = -1;
};

/// Writes the index of a pyramid into `folder`, after the chunk files. Errors: io.
void write_index(const std::filesystem::path& folder, const Digest& digest,
                 const std::vector<LevelFacts>& levels);
/// Errors: io, also where the index is damaged or another pyramid's.
std::vector<LevelFacts> read_index(const std::filesystem::path& folder, const Digest& digest);

/// Where the index of the pyramid in `folder` is; one without it is none.
std::filesystem::path index_file(const std::filesystem::path& folder);
std::filesystem::path level_file(const std::filesystem::path& folder, std::size_t level);

}  // namespace hoodoo::dem
