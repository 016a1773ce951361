#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/job/delivery.hpp"
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
  bool told = false;                              // only jobs of which no callback is owed
  std::size_t limit = 10;
};

struct Database;

/// Jobs on disk, in SQLite with a write-ahead log: what a call changed is there after a power
/// failure, whole. With them the callbacks that are owed, and whose and how long unused assets are.
/// For one thread at a time.
/// Errors of all members: io.
class Store {
 public:
  /// Errors: io, also for a file that is damaged or of a newer release.
  explicit Store(const std::filesystem::path& file);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  /// Gives the job its serial. False, and nothing is kept, when its owner used its key before; a
  /// job that has failed or was dismissed holds its key no more.
  /// `assets` are those that it names.
  bool insert(Job& job, const std::vector<std::string>& assets = {});
  /// With the callback that is owed for the change, if any. One event of a job is owed once; a job
  /// that is dismissed owes nothing any more.
  void update(const Job& job, const std::optional<Delivery>& owed = {});
  void remove(std::string_view id);
  /// Every job that ran waits again: for when the store is opened.
  void interrupt_all();

  /// Without their reports, as all that gives jobs.
  std::optional<Job> find(std::string_view id) const;
  std::optional<Job> find_key(std::string_view owner, std::string_view key) const;
  /// Of the jobs that wait, the first of the highest priority.
  std::optional<Job> first_waiting() const;
  /// Newest first. `now` is when a job that runs is as old as it is.
  std::vector<Job> list(const Filter& filter, Time now) const;
  std::size_t count(Status status, std::optional<std::string_view> owner = {}) const;
  /// As JSON; empty where there is none.
  std::string report(std::string_view id) const;

  /// Of the callbacks that are owed to other hosts than these, the one that is due first.
  std::optional<Delivery> first_delivery(const std::set<std::string>& left_out = {}) const;
  std::size_t count_deliveries() const;
  /// One more try: due again then, or settled.
  void tried(const Delivery& delivery, std::optional<Time> again);
  /// Nothing is owed any more: for this job, or for all.
  void drop_deliveries(std::optional<std::string_view> job = {});

  /// What the folders of jobs take on the disk, once they have ended and been counted; their
  /// reports are added to it.
  void set_bytes(std::string_view job, std::uint64_t bytes);
  std::vector<std::string> uncounted() const;  // jobs that have ended
  /// All that is known of one owner's: jobs that were counted, and assets.
  std::uint64_t bytes_of(std::string_view owner) const;

  /// An asset that came from `owner`, where none is known of that name.
  void add_asset(const std::string& name, const std::string& owner, std::uint64_t bytes, Time now);
  void remove_asset(std::string_view name);
  std::optional<std::string> owner_of(std::string_view asset) const;
  std::optional<Time> last_use(std::string_view asset) const;  // or arrival
  std::vector<std::string> assets() const;
  /// A job that waits or runs names it.
  bool is_used(std::string_view asset) const;

 private:
  void add(const Delivery& owed);
  void note_use(std::string_view job, Time now);

  std::unique_ptr<Database> database_;
};

}  // namespace hoodoo::job
