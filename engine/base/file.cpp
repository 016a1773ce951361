#include "engine/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <random>
#include <system_error>

#include "engine/base/error.hpp"

namespace hoodoo {
namespace {

constexpr std::string_view leftover_suffix = ".part";

/// What sets this process apart from those of other machines that share a file system.
const std::string& process_name() {
  static const std::string name =
      std::to_string(::getpid()) + "-" + std::to_string(std::random_device()());
  return name;
}

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view doing, int error) {
  throw Error(error == ENOENT ? Fault::not_found : Fault::io, path.string(),
              std::string(doing) + ": " + std::generic_category().message(error));
}

/// A file descriptor that closes itself.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

std::string read_file(const std::filesystem::path& path, std::uintmax_t most) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) fail(path, "cannot be opened", errno);
  struct stat status {};
  if (::fstat(file.fd, &status) != 0) fail(path, "cannot be read", errno);
  if (S_ISDIR(status.st_mode)) throw Error(Fault::bad_input, path.string(), "is a directory");
  const auto too_long = [&] {
    return Error(Fault::limit, path.string(),
                 "is longer than the limit of " + std::to_string(most) + " bytes");
  };
  if (status.st_size > 0 && static_cast<std::uintmax_t>(status.st_size) > most) throw too_long();
  std::string text;
  char buffer[1 << 16];
  for (;;) {
    const auto got = ::read(file.fd, buffer, sizeof buffer);
    if (got == 0) return text;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path, "cannot be read", errno);
    text.append(buffer, static_cast<std::size_t>(got));
    if (text.size() > most) throw too_long();
  }
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  static std::atomic<unsigned> serial{0};
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (error) fail(path.parent_path(), "cannot be made", error.value());
  auto part = path;
  part += "." + process_name() + "-" + std::to_string(++serial);
  part += leftover_suffix;
  const auto give_up = [&](std::string_view doing) {
    const int why = errno;
    ::unlink(part.c_str());
    fail(path, doing, why);
  };
  {
    const Descriptor file{::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (file.fd < 0) fail(path, "cannot be written", errno);
    for (std::size_t done = 0; done < bytes.size();) {
      const auto put = ::write(file.fd, bytes.data() + done, bytes.size() - done);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) give_up("cannot be written");
      done += static_cast<std::size_t>(put);
    }
    if (::fsync(file.fd) != 0) give_up("cannot be written to disk");
  }
  if (::rename(part.c_str(), path.c_str()) != 0) give_up("cannot be renamed into place");
}
void write_file(const std::filesystem::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span(text)));
}

bool is_leftover(const std::filesystem::path& path) {
  return path.extension().string() == leftover_suffix;
}

}  // namespace hoodoo
