#pragma once
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/hash.hpp"

namespace hoodoo::store {

/// A folder of finished tiles by the hash of their slice, for any number of bakes, processes and
/// machines that trust each other. Equal slices have equal tiles, so it does not matter who wrote
/// an entry, and no entry grows stale; those that are not wanted any more may be deleted at any
/// time.
///
/// An entry is one file, written whole or not at all. What it holds is checked against a digest in
/// its first line: one that is damaged counts as absent, and the next `put` replaces it.
/// May be used from any thread.
class Cache {
 public:
  struct Entry {
    std::string record;  // what is known of the tile, as its baker wrote it
    std::vector<std::byte> tile;
  };

  explicit Cache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<Entry> get(const Digest& slice) const;
  bool has(const Digest& slice) const;  // there, if perhaps damaged
  /// A tile that cannot be written is none that is lost: nothing more is written after that, and
  /// `warning` says why.
  void put(const Digest& slice, std::string_view record, std::span<const std::byte> tile);
  std::string warning() const;  // empty when there is none

 private:
  std::filesystem::path path_of(const Digest& slice) const;

  const std::filesystem::path folder_;
  std::atomic<bool> failed_ = false;
  mutable std::mutex mutex_;
  std::string warning_;  // guarded by mutex_
};

}  // namespace hoodoo::store
