#pragma once
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <variant>

#include "server/asset/assets.hpp"

namespace hoodoo::asset {

using Time = std::chrono::sys_time<std::chrono::seconds>;

/// What is known of one upload.
struct Upload {
  std::string id;     // 32 lower-case hexadecimal digits, which cannot be guessed
  std::string owner;  // empty where nobody has a name
  std::uint64_t length = 0, offset = 0;  // [bytes] of the whole, and of what is here
  std::optional<Digest> wanted;          // what it is said to be
  std::optional<Digest> made;            // the asset that it has become
  Time expires{};
};

/// Assets that arrive in parts, over any time and any number of connections.
///
/// An upload is data/uploads/ID.json and, until it has become an asset, ID.data, whose size is its
/// offset: so it goes on after the server was killed. One that nothing was added to for a while is
/// removed; one that is finished is remembered as long, or until `most` others are.
///
/// Every member may be called from any thread.
class Uploads {
 public:
  /// `patience` is how long an upload is kept. Errors: io.
  Uploads(Assets& assets, std::chrono::seconds patience);
  ~Uploads();
  Uploads(const Uploads&) = delete;
  Uploads& operator=(const Uploads&) = delete;

  static constexpr std::size_t most = 1000;          // that are under way
  static constexpr std::size_t most_of_owner = 100;  // and of one who has a name

  /// Why there can be no more: so many of all, or of this owner, are under way.
  enum class Full { all, owner };
  /// Errors: as Assets::reserve.
  std::variant<Upload, Full> create(std::uint64_t length, const std::optional<Digest>& wanted,
                                    const std::string& owner);
  std::optional<Upload> find(std::string_view id) const;
  /// What an owner's uploads will be that are no assets yet [bytes].
  std::uint64_t under_way(std::string_view owner) const;

 private:
  struct Record;

 public:
  /// The right to add to one upload, of one holder at a time.
  class Turn {
   public:
    Turn(Uploads& uploads, std::shared_ptr<Record> record);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    std::uint64_t offset() const { return file_.size(); }
    void make_room(std::uint64_t bytes) { file_.make_room(bytes); }
    void add(std::string_view bytes) { file_.add(bytes); }
    void cut(std::uint64_t size) { file_.cut(size); }
    /// Puts what came on the disk; makes the upload an asset once it is whole. What it is then.
    /// Errors: io; bad_input, its digest is another one: the upload is gone.
    Upload end();

   private:
    Uploads& uploads_;
    const std::shared_ptr<Record> record_;
    Incoming file_;
  };
  /// Null while another one has it, or when there is no such unfinished upload. Errors: io.
  std::unique_ptr<Turn> take(std::string_view id);

  /// Removes an upload, not the asset that it has become. False while it is added to.
  bool remove(std::string_view id);

 private:
  void open();
  void open_one(const std::string& id);
  void collect();
  void forget_oldest();
  std::optional<Full> full(std::string_view owner) const;
  void save(const Upload& upload) const;
  void forget(const std::string& id) const;
  std::filesystem::path data_of(std::string_view id) const;
  std::filesystem::path state_of(std::string_view id) const;

  Assets& assets_;
  const std::filesystem::path folder_;
  const std::chrono::seconds patience_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Record>, std::less<>> records_;  // guarded by mutex_
  std::condition_variable_any waiting_;
  std::jthread collector_;  // last: the first to go
};

}  // namespace hoodoo::asset
