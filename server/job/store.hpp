#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/job/job.hpp"

namespace hoodoo::job {

/// Which jobs to list. Bounds are inclusive.
struct Filter {
  std::vector<Status> statuses;                   // empty: all
  std::vector<std::string> processes;             // empty: all
  std::optional<std::string> owner;               // none: anybody's
  std::optional<Time> from, to;                   // of creation
  std::optional<std::int64_t> shortest, longest;  // [ms] run so far; a job that waits has none
  std::optional<std::uint64_t> before;            // serial; exclusive
  std::optional<Time> ended_by;                   // jobs that ended then or earlier
  std::size_t limit = 10;
};

/// Jobs on disk, in SQLite with a write-ahead log: what a call changed is there after a power
/// failure, whole. For one thread at a time.
/// Errors of all members: io.
class Store {
 public:
  /// Errors: io, also for a file that is damaged or of a newer release.
  explicit Store(const std::filesystem::path& file);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// Gives the job its serial. False, and nothing is kept, when its owner used its key before.
  bool insert(Job& job);
  void update(const Job& job);
  void remove(std::string_view id);
  /// Every job that ran waits again: for when the store is opened.
  void interrupt_all();

  std::optional<Job> find(std::string_view id) const;
  std::optional<Job> find_key(std::string_view owner, std::string_view key) const;
  /// Of the jobs that wait, the first of the highest priority.
  std::optional<Job> first_waiting() const;
  /// Newest first. `now` is when a job that runs is as old as it is.
  std::vector<Job> list(const Filter& filter, Time now) const;
  std::size_t count(Status status, std::optional<std::string_view> owner = {}) const;

 private:
  struct Database;
  std::unique_ptr<Database> database_;
};

}  // namespace hoodoo::job
