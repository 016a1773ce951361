#pragma once
#include <filesystem>
#include <stop_token>

namespace hoodoo {

/// A lock on a file by which threads and processes take turns (flock). The system lets go of it
/// when its process dies; the file stays.
class FileLock {
 public:
  enum class Kind { shared, exclusive };

  /// Waits for the lock; makes the file and its folder where they are missing.
  /// Errors: io; cancelled when `stop` is requested while it waits.
  FileLock(const std::filesystem::path& path, Kind kind, const std::stop_token& stop);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// Makes a shared lock exclusive when nobody else holds it. Otherwise this one is lost, too.
  bool make_exclusive();

  /// Somebody holds a lock on the file at `path`. Makes no file; false where there is none.
  static bool is_held(const std::filesystem::path& path);

 private:
  int fd_;
};

}  // namespace hoodoo
