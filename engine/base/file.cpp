#include "engine/base/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"

namespace hoodoo {
namespace {

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

std::optional<FileState> file_state(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileState{
      static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino),
      static_cast<std::uint64_t>(status.st_size), status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  FileWriter file(path);
  file.write(bytes);
  file.commit();
}
void write_file_unsynced(const std::filesystem::path& path, std::string_view text) {
  FileWriter file(path);
  file.write(text);
  file.commit_unsynced();
}
void write_file(const std::filesystem::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span(text)));
}

bool is_leftover(const std::filesystem::path& path) {
  return path.extension().string() == leftover_suffix;
}

}  // namespace hoodoo
