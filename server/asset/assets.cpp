#include "server/asset/assets.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

namespace hoodoo::asset {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "sha256-";

fs::path made(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(Fault::io, folder.string(), "cannot be made: " + error.message());
  return fs::canonical(folder);
}

}  // namespace

std::uint64_t left_on_disk(const fs::path& folder) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return 0;
  return std::uint64_t{status.f_bavail} * status.f_frsize;
}

std::optional<Digest> digest_of(std::string_view name) {
  if (!name.starts_with(prefix)) return std::nullopt;
  return Digest::parse(name.substr(prefix.size()));
}
std::string name_of(const Digest& digest) { return std::string(prefix) + digest.hex(); }

std::string other_digest(const Digest& wanted, const Digest& found) {
  return fmt::format("has the SHA-256 {}, not {}", found.hex(), wanted.hex());
}

std::string random_name() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw Error(Fault::io, "", "the system gives no random bytes");
  }
  std::string name;
  for (const unsigned byte : bytes) name += fmt::format("{:02x}", byte);
  return name;
}

Assets::Assets(const fs::path& data, std::uint64_t most, std::uint64_t free_space)
    : assets_(made(data / "assets")),
      uploads_(made(data / "uploads")),
      most_(most),
      free_space_(free_space) {
  std::vector<fs::path> leftovers;
  for (const auto& item : fs::directory_iterator(uploads_)) {
    if (is_leftover(item.path())) leftovers.push_back(item.path());
  }
  for (const auto& path : leftovers) fs::remove(path);
}

fs::path Assets::file(const Digest& digest) const { return assets_ / name_of(digest); }

bool Assets::holds(const Digest& digest) const {
  struct stat status {};
  return ::lstat(file(digest).c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

/// Looked up each time, so that an asset that was removed by hand leaves its space.
std::uint64_t Assets::used() const {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (const auto& item : fs::directory_iterator(assets_, error)) {
    std::error_code gone;
    const auto size = item.file_size(gone);
    if (!gone) bytes += size;
  }
  return bytes;
}

Space Assets::reserve(std::uint64_t bytes) {
  if (bytes > most_) {
    throw Error(Fault::limit, "",
                fmt::format("an asset may have at most {} bytes here, got {}", most_, bytes));
  }
  const std::lock_guard guard(mutex_);
  const auto taken = used() + reserved_;
  if (taken > most_ || bytes > most_ - taken) {
    throw Error(Fault::io, "",
                fmt::format("there is {} for {} bytes: of {} bytes for assets {} are taken",
                            no_space, bytes, most_, taken));
  }
  const auto left = left_on_disk(uploads_);
  if (left < free_space_ || bytes > left - free_space_) {
    throw Error(Fault::io, "",
                fmt::format("the disk has {} for {} bytes: it has {} left, and {} are kept free",
                            no_space, bytes, left, free_space_));
  }
  reserved_ += bytes;
  return {new std::uint64_t(bytes), [this](const std::uint64_t* held) {
            const std::lock_guard again(mutex_);
            reserved_ -= *held;
            delete held;
          }};
}

void Assets::adopt(const fs::path& from, const Digest& digest) const {
  const auto to = file(digest);
  ::chmod(from.c_str(), S_IRUSR | S_IRGRP | S_IROTH);
  const int folder = ::open(assets_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool well = folder >= 0 && ::rename(from.c_str(), to.c_str()) == 0 && ::fsync(folder) == 0;
  const int why = errno;
  if (folder >= 0) ::close(folder);
  if (!well) {
    throw Error(Fault::io, to.filename().string(),
                "cannot be put in its place: " + std::generic_category().message(why));
  }
}

std::vector<std::string> Assets::list() const {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& item : fs::directory_iterator(assets_, error)) {
    auto name = item.path().filename().string();
    if (digest_of(name)) names.push_back(std::move(name));
  }
  return names;
}

void Assets::remove(const Digest& digest) const {
  if (::unlink(file(digest).c_str()) == 0 || errno == ENOENT) return;
  throw Error(Fault::io, name_of(digest),
              "cannot be removed: " + std::generic_category().message(errno));
}

Draft::Draft(Assets& assets, std::uint64_t bytes)
    : assets_(assets),
      space_(assets.reserve(bytes)),
      path_(assets.under_way() / (random_name() + std::string(leftover_suffix))) {
  file_.emplace(path_, hash_);
  try {
    file_->make_room(bytes);
  } catch (...) {
    ::unlink(path_.c_str());
    throw;
  }
}

Draft::~Draft() {
  if (file_) ::unlink(path_.c_str());
}

Digest Draft::commit(const std::optional<Digest>& wanted) {
  const auto found = file_->digest();
  if (wanted && found != *wanted) throw Error(Fault::bad_input, "", other_digest(*wanted, found));
  file_->sync();
  assets_.adopt(path_, found);
  file_.reset();
  return found;
}

}  // namespace hoodoo::asset
