#include "server/asset/incoming.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"

namespace hoodoo::asset {
namespace {

constexpr std::uint64_t written_at_once = 8u << 20;  // [bytes]
constexpr std::size_t read_at_once = 256u << 10;     // [bytes]

}  // namespace

void Incoming::fail(const char* doing) const {
  throw Error(Fault::io, path_.filename().string(),
              std::string(doing) + ": " + std::generic_category().message(errno));
}

Incoming::Incoming(std::filesystem::path file, RunningHash& hash)
    : path_(std::move(file)), running_(hash) {
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) fail("cannot be written");
  struct stat status {};
  if (::fstat(file_, &status) != 0) fail("cannot be read");
  size_ = begun_ = static_cast<std::uint64_t>(status.st_size);
  if (!running_.hash || running_.size > size_) running_.restart();
}

Incoming::~Incoming() {
  if (file_ >= 0) ::close(file_);
}

void Incoming::make_room(std::uint64_t bytes) {
  if (bytes == 0) return;
  const int failed =
      ::fallocate(file_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(size_), static_cast<off_t>(bytes));
  if (failed != 0 && errno != EOPNOTSUPP && errno != ENOSYS) fail("has no room");
}

void Incoming::add(std::string_view bytes) {
  // A hash that lacks earlier bytes takes all of them at the end.
  if (running_.size == size_) {
    running_.hash->add(bytes);
    running_.size += bytes.size();
  }
  while (!bytes.empty()) {
    const auto put = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) {
      if (running_.size > size_) running_.restart();
      fail("cannot be written");
    }
    size_ += static_cast<std::uint64_t>(put);
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  write_behind();
}

/// Has the disk write while more arrives, so that the wait at the end is short.
void Incoming::write_behind() {
  if (size_ - begun_ < written_at_once) return;
  ::sync_file_range(file_, static_cast<off_t>(begun_), static_cast<off_t>(size_ - begun_),
                    SYNC_FILE_RANGE_WRITE);
  begun_ = size_;
}

void Incoming::cut(std::uint64_t size) {
  if (::ftruncate(file_, static_cast<off_t>(size)) != 0) fail("cannot be cut");
  size_ = begun_ = size;
  if (running_.size > size) running_.restart();
}

void Incoming::sync() {
  if (::fsync(file_) != 0) fail("cannot be written to disk");
}

void Incoming::catch_up() {
  std::vector<char> piece(read_at_once);
  while (running_.size < size_) {
    const auto got = ::pread(file_, piece.data(), piece.size(), static_cast<off_t>(running_.size));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail("cannot be read");
    running_.hash->add(std::string_view(piece.data(), static_cast<std::size_t>(got)));
    running_.size += static_cast<std::uint64_t>(got);
  }
}

Digest Incoming::digest() {
  if (running_.size < size_) catch_up();
  const auto digest = running_.hash->finish();
  running_.hash.reset();
  running_.size = 0;
  return digest;
}

}  // namespace hoodoo::asset
