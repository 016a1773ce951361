#include "engine/dem/chunks.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/json.hpp"

namespace hoodoo::dem {
namespace {

static_assert(std::endian::native == std::endian::little, "chunks are little-endian on disk");

constexpr std::size_t entry_bytes = 32 + 3 * 4;
constexpr const char* format_name = "hoodoo pyramid 2";

[[noreturn]] void fail(const std::filesystem::path& path, const char* doing) {
  throw Error(Fault::io, path.string(),
              fmt::format("{}: {}", doing, std::generic_category().message(errno)));
}

std::string entries(const std::vector<LevelFacts>& levels) {
  std::string bytes;
  for (const auto& level : levels) {
    for (const auto& chunk : level.chunks) {
      char entry[entry_bytes];
      std::memcpy(entry, chunk.digest.bytes.data(), 32);
      std::memcpy(entry + 32, &chunk.low, 4);
      std::memcpy(entry + 36, &chunk.high, 4);
      std::memcpy(entry + 40, &chunk.valid, 4);
      bytes.append(entry, entry_bytes);
    }
  }
  return bytes;
}

/// Of all that an index says.
std::string check_of(const nlohmann::json& levels, const std::string& table) {
  return sha256(levels.dump() + "\n" + table).hex();
}

ChunkFacts entry_at(const char* entry) {
  ChunkFacts chunk;
  std::memcpy(chunk.digest.bytes.data(), entry, 32);
  std::memcpy(&chunk.low, entry + 32, 4);
  std::memcpy(&chunk.high, entry + 36, 4);
  std::memcpy(&chunk.valid, entry + 40, 4);
  return chunk;
}

}  // namespace

ChunkFacts describe_chunk(std::span<float> pixels) {
  assert(pixels.size() == chunk_pixels);
  ChunkFacts facts;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (float& v : pixels) {
    if (std::isnan(v)) {
      v = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    ++facts.valid;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (facts.valid) {
    facts.low = low;
    facts.high = high;
    facts.digest = sha256(std::as_bytes(pixels));
  } else {
    // Rasters of half a planet are mostly such chunks.
    static const Digest hole = sha256(std::as_bytes(pixels));
    facts.digest = hole;
  }
  return facts;
}

ChunkFile::ChunkFile(std::filesystem::path path, Mode mode) : path_(std::move(path)) {
  const int flags = mode == Mode::read ? O_RDONLY : O_RDWR | O_CREAT | O_TRUNC;
  fd_ = ::open(path_.c_str(), flags | O_CLOEXEC, 0644);
  if (fd_ < 0) fail(path_, "cannot be opened");
}

ChunkFile::~ChunkFile() {
  if (fd_ >= 0) ::close(fd_);
}

ChunkFile::ChunkFile(ChunkFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}

void ChunkFile::write(std::size_t chunk, std::size_t first, std::span<const float> pixels) {
  const auto bytes = std::as_bytes(pixels);
  const auto start = chunk * chunk_bytes + first * sizeof(float);
  for (std::size_t done = 0; done < bytes.size();) {
    const auto put =
        ::pwrite(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(start + done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail(path_, "cannot be written");
    done += static_cast<std::size_t>(put);
  }
}

void ChunkFile::read(std::size_t chunk, std::span<float> pixels) const {
  const auto bytes = std::as_writable_bytes(pixels);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto got = ::pread(fd_, bytes.data() + done, bytes.size() - done,
                             static_cast<off_t>(chunk * chunk_bytes + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path_, "cannot be read");
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(done), bytes.end(), std::byte{0});
}

void ChunkFile::sync() {
  if (::fsync(fd_) != 0) fail(path_, "cannot be written to disk");
}

std::filesystem::path index_file(const std::filesystem::path& folder) {
  return folder / "pyramid.json";
}

std::filesystem::path level_file(const std::filesystem::path& folder, std::size_t level) {
  return folder / fmt::format("level_{}.f32", level);
}

void write_index(const std::filesystem::path& folder, const Digest& digest,
                 const std::vector<LevelFacts>& levels) {
  const auto table = entries(levels);
  nlohmann::json json = {{"format", format_name},
                         {"digest", digest.hex()},
                         {"chunk_side", chunk_side},
                         {"levels", nlohmann::json::array()}};
  for (const auto& [grid, chunks] : levels) {
    json["levels"].push_back({{"x0", grid.x0},
                              {"y0", grid.y0},
                              {"dx", grid.dx},
                              {"dy", grid.dy},
                              {"width", grid.width},
                              {"height", grid.height}});
  }
  json["check"] = check_of(json["levels"], table);
  write_file(folder / "chunks.bin", table);
  write_file(index_file(folder), json.dump(1) + "\n");
}

std::vector<LevelFacts> read_index(const std::filesystem::path& folder, const Digest& digest) {
  const auto index = index_file(folder);
  const auto damaged = [&] { return Error(Fault::io, folder.string(), "is a damaged pyramid"); };
  try {
    const auto json = parse_json(read_file(index, 1 << 20), index.string());
    if (json.at("format") != format_name || json.at("digest") != digest.hex()) throw damaged();
    std::vector<LevelFacts> levels;
    std::size_t count = 0;
    for (const auto& level : json.at("levels")) {
      LevelFacts facts{{level.at("x0"), level.at("y0"), level.at("dx"), level.at("dy"),
                        level.at("width"), level.at("height")},
                       {}};
      facts.chunks.resize(static_cast<std::size_t>(facts.across() * facts.down()));
      count += facts.chunks.size();
      levels.push_back(std::move(facts));
    }
    const auto table = read_file(folder / "chunks.bin", count * entry_bytes);
    if (levels.empty() || table.size() != count * entry_bytes ||
        check_of(json.at("levels"), table) != json.at("check")) {
      throw damaged();
    }
    const char* entry = table.data();
    for (auto& level : levels) {
      for (auto& chunk : level.chunks) {
        chunk = entry_at(entry);
        entry += entry_bytes;
      }
    }
    return levels;
  } catch (const nlohmann::json::exception&) {
    throw damaged();
  }
}

}  // namespace hoodoo::dem
