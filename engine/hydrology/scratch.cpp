#include "engine/hydrology/scratch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo::hydrology {
namespace {

Error failed(const std::filesystem::path& folder, const char* doing) {
  return {Fault::io, folder.string(),
          fmt::format("cannot {} a temporary file here: {}", doing,
                      std::generic_category().message(errno))};
}

}  // namespace

Scratch::Scratch(std::filesystem::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) folder_ = ".";
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  auto name = (folder_ / "hoodoo-XXXXXX.part").string();
  file_ = mkostemps(name.data(), 5, O_CLOEXEC);
  if (file_ < 0) throw failed(folder_, "make");
  unlink(name.c_str());
}

Scratch::~Scratch() { close(file_); }

void Scratch::write_bytes(std::uint64_t at, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto n = pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw failed(folder_, "write");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    at += static_cast<std::uint64_t>(n);
  }
}

void Scratch::read_bytes(std::uint64_t at, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const auto n = pread(file_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw failed(folder_, "read");
    if (n == 0) {
      std::ranges::fill(bytes, std::byte{0});
      return;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    at += static_cast<std::uint64_t>(n);
  }
}

}  // namespace hoodoo::hydrology
