#include "engine/base/lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "engine/base/error.hpp"

namespace hoodoo {

FileLock::FileLock(const std::filesystem::path& path, Kind kind, const std::stop_token& stop)
    : fd_(-1) {
  const auto fail = [&](int error) {
    if (fd_ >= 0) ::close(fd_);
    throw Error(Fault::io, path.string(),
                "cannot be locked: " + std::generic_category().message(error));
  };
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (error) fail(error.value());
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0) fail(errno);
  const int wanted = (kind == Kind::shared ? LOCK_SH : LOCK_EX) | LOCK_NB;
  while (::flock(fd_, wanted) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) fail(errno);
    if (stop.stop_requested()) {
      ::close(fd_);
      throw Error(Fault::cancelled, path.string(), "waiting for another run was cancelled");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

FileLock::~FileLock() { ::close(fd_); }

bool FileLock::is_held(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool held = ::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(fd);
  return held;
}

bool FileLock::make_exclusive() { return ::flock(fd_, LOCK_EX | LOCK_NB) == 0; }

}  // namespace hoodoo
