#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/hash.hpp"
#include "server/asset/incoming.hpp"

/// server/asset: contents that clients have sent, named by their SHA-256.
namespace hoodoo::asset {

/// "sha256-" and 64 lower-case hexadecimal digits; nothing for any other text.
std::optional<Digest> digest_of(std::string_view name);
std::string name_of(const Digest& digest);

/// Space that is kept for content under way, until its last holder is gone, which must be before
/// the assets are.
using Space = std::shared_ptr<const std::uint64_t>;

/// What every error says that tells of a lack of it.
inline constexpr std::string_view no_space = "no space";

/// Bytes that may still be written to the disk of a folder.
std::uint64_t left_on_disk(const std::filesystem::path& folder);

/// Finished contents in data/assets, each whole and on the disk, never changed; what is under way
/// lies in data/uploads, where no job may read.
///
/// For one process at a time, any thread.
class Assets {
 public:
  /// `most` bytes in all, of which the disk keeps `free_space` bytes free, for jobs. Removes what a
  /// killed server had under way, but no upload that can be resumed. Errors: io.
  Assets(const std::filesystem::path& data, std::uint64_t most, std::uint64_t free_space = 0);

  std::uint64_t most() const { return most_; }
  bool holds(const Digest& digest) const;
  std::filesystem::path file(const Digest& digest) const;
  const std::filesystem::path& under_way() const { return uploads_; }

  /// Keeps space for one content. Errors: limit, it is more than `most`; io, there is too little
  /// left of that, or on the disk.
  Space reserve(std::uint64_t bytes);
  /// Makes a file in data/uploads, on the disk already, an asset. Errors: io.
  void adopt(const std::filesystem::path& file, const Digest& digest) const;
  /// The names of all there are.
  std::vector<std::string> list() const;
  /// One that is open can be read to its end. Errors: io.
  void remove(const Digest& digest) const;

 private:
  std::uint64_t used() const;

  std::filesystem::path assets_, uploads_;
  const std::uint64_t most_, free_space_;
  std::mutex mutex_;
  std::uint64_t reserved_ = 0;  // [bytes] under way; guarded by mutex_
};

/// One content that arrives at once; gone with its holder unless it was committed.
class Draft {
 public:
  /// Takes space and room for all of it. Errors: as Assets::reserve, io.
  Draft(Assets& assets, std::uint64_t bytes);
  ~Draft();
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;

  void add(std::string_view bytes) { file_->add(bytes); }
  /// Makes it an asset; its digest. Errors: bad_input, it is not the one that was wanted; io.
  Digest commit(const std::optional<Digest>& wanted);

 private:
  Assets& assets_;
  const Space space_;
  const std::filesystem::path path_;
  RunningHash hash_;
  std::optional<Incoming> file_;
};

/// What to say of a content that is not what it was said to be.
std::string other_digest(const Digest& wanted, const Digest& found);
/// 128 random bits as hexadecimal digits. Errors: io.
std::string random_name();

}  // namespace hoodoo::asset
