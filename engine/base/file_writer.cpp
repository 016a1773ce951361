#include "engine/base/file_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <random>
#include <string>
#include <system_error>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

namespace hoodoo {
namespace {

constexpr std::size_t most_waiting = std::size_t{1} << 20;  // [bytes]

/// What sets this process apart from those of other machines that share a file system.
const std::string& process_name() {
  static const std::string name =
      std::to_string(::getpid()) + "-" + std::to_string(std::random_device()());
  return name;
}

std::filesystem::path part_of(std::filesystem::path path) {
  static std::atomic<unsigned> serial{0};
  path += "." + process_name() + "-" + std::to_string(++serial);
  path += leftover_suffix;
  return path;
}

}  // namespace

void FileWriter::fail(std::string_view doing) const {
  const int why = errno;
  throw Error(why == ENOENT ? Fault::not_found : Fault::io, path_.string(),
              std::string(doing) + ": " + std::generic_category().message(why));
}

FileWriter::FileWriter(std::filesystem::path path) : path_(std::move(path)), part_(part_of(path_)) {
  std::error_code error;
  if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path(), error);
  if (error) {
    throw Error(Fault::io, path_.parent_path().string(), "cannot be made: " + error.message());
  }
  file_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file_ < 0) fail("cannot be written");
}

FileWriter::~FileWriter() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(part_.c_str());
}

void FileWriter::write(std::span<const std::byte> bytes) {
  position_ += bytes.size();
  if (waiting_.size() + bytes.size() <= most_waiting) {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    return;
  }
  flush();
  pass_on(bytes);
}
void FileWriter::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void FileWriter::flush() {
  pass_on(waiting_);
  waiting_.clear();
}

void FileWriter::pass_on(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto put = ::write(file_, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail("cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
}

void FileWriter::seek(std::uint64_t position) {
  flush();
  if (::lseek(file_, static_cast<off_t>(position), SEEK_SET) < 0) fail("cannot be written");
  position_ = position;
}

void FileWriter::sync() {
  flush();
  if (::fsync(file_) != 0) fail("cannot be written to disk");
}

void FileWriter::commit() {
  sync();
  commit_unsynced();
}

void FileWriter::commit_unsynced() {
  flush();
  if (::rename(part_.c_str(), path_.c_str()) != 0) fail("cannot be renamed into place");
  ::close(file_);
  file_ = -1;
}

}  // namespace hoodoo
