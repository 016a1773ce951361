#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "engine/base/hash.hpp"

namespace hoodoo::asset {

/// The hash of a file's first bytes, so that the next ones need not be read again.
struct RunningHash {
  std::optional<Sha256> hash;
  std::uint64_t size = 0;  // [bytes] of the file that it holds
  void restart() {
    hash.emplace();
    size = 0;
  }
};

/// A file that grows as its content arrives, hashed on the way. It keeps what is on the disk when
/// it is opened.
/// Errors of all members: io.
class Incoming {
 public:
  Incoming(std::filesystem::path file, RunningHash& hash);
  ~Incoming();
  Incoming(const Incoming&) = delete;
  Incoming& operator=(const Incoming&) = delete;

  std::uint64_t size() const { return size_; }
  /// Takes room on the disk for so many more bytes, where the file system can.
  void make_room(std::uint64_t bytes);
  void add(std::string_view bytes);
  /// Takes back all but the first `size` bytes.
  void cut(std::uint64_t size);
  /// Waits until all of it is on the disk.
  void sync();
  /// The digest of the whole file, once; reads what the running hash does not hold.
  Digest digest();

 private:
  [[noreturn]] void fail(const char* doing) const;
  void write_behind();
  void catch_up();

  std::filesystem::path path_;
  RunningHash& running_;
  int file_ = -1;
  std::uint64_t size_ = 0, begun_ = 0;  // the disk has been told to write up to `begun_`
};

}  // namespace hoodoo::asset
