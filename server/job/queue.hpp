#pragma once
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/job/job.hpp"
#include "server/job/pace.hpp"
#include "server/job/store.hpp"

namespace hoodoo::job {

/// One job to carry out.
struct Work {
  std::string process;
  std::filesystem::path folder;  // scene.json of a bake; results go to out/
  nlohmann::json inputs;         // of every other process
  std::filesystem::path reuse;   // results of an earlier bake; empty: of none
  Bounds bounds;                 // of a bake
  std::stop_token stop;
  std::function<void(const bake::Progress&)> progress;
};

/// The two functions a queue needs of whoever does the work.
struct Engine {
  /// All problems of the scene in a file. Called from any thread.
  std::function<std::vector<Problem>(const std::filesystem::path& scene)> check;
  /// Carries a job out; ends soon after a stop request. Called by the threads of the queue.
  std::function<Outcome(const Work&)> run;
};

struct Settings {
  std::filesystem::path data;      // state; made when absent
  int at_once = 1;                 // jobs that run
  std::size_t most_waiting = 100;  // jobs accepted but not started, of all owners
  std::size_t most_of_owner = 50;  // and of one
  /// How long a job that has ended is kept with its results; 0: until it is dismissed.
  std::chrono::seconds keep{0};
  std::uint64_t free_space = 0;  // [bytes] no jobs are taken when the disk has less left
  /// What a subscriber is told of a job that has just come to its status. Without it nobody is told
  /// anything, and what an earlier queue owed is dropped. May not ask the queue.
  std::function<std::string(const Job&, const std::filesystem::path& results)> announce;
};

/// What became of a request.
struct Submitted {
  enum class Kind {
    taken,
    replayed,
    queue_full,
    owner_full,   // the owner has `used` jobs of `most`
    owner_space,  // and so many bytes
    key_reused
  } kind = Kind::taken;
  Job job;  // of the first two
  std::uint64_t used = 0, most = 0;
};

/// What became of the callbacks that were owed, since the queue was made.
struct Told {
  std::size_t pending = 0;  // now
  std::uint64_t delivered = 0, failed_tries = 0, given_up = 0;
};

/// Jobs in the order of their priority, then as they came, carried out by threads of the queue.
///
/// A job lives in data/jobs/ID, scene.json or inputs.json and its results in out/, and as a row of
/// data/jobs.db, on the disk before anybody hears of it. A bake whose inputs name a "base", the id
/// of an earlier one, takes from that what would be the same, as long as it is kept. A queue on the
/// same data takes up what an earlier one, stopped or killed, did not finish: a bake continues from
/// its finished tiles. One process at a time may use the data. Every member may be called from any
/// thread.
class Queue {
 public:
  /// Errors: io (the data cannot be used, or another process does).
  Queue(Settings settings, Engine engine);
  /// Stops what is running; it continues when the next queue opens the data.
  ~Queue();
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// Takes a request whose scene has no problems. A key that its owner used before gives the job
  /// it was used for, as long as that is kept and has neither failed nor been dismissed.
  /// Errors: bad_input with every problem and its pointer into the scene; limit; io, also when the
  /// disk is nearly full.
  Submitted submit(const Request& request);

  std::optional<Job> find(std::string_view id) const;
  std::vector<Job> list(const Filter& filter) const;
  std::size_t count(Status status) const;
  /// What a job that has ended well tells of itself; null where there is nothing.
  std::shared_ptr<const nlohmann::json> report(std::string_view id) const;
  /// The next request would be refused.
  bool is_full() const;

  /// Cancels a job that waits or runs; removes one that has ended, with its results, once nothing
  /// writes there any more. What it was, or none if there is no such job.
  std::optional<Job> dismiss(std::string_view id);

  /// Where a job's results are written. The id must be that of a job.
  std::filesystem::path results(std::string_view id) const;

  /// All problems of a scene. Errors: limit, io.
  std::vector<Problem> check(const nlohmann::json& scene) const;

  /// Waits for the callback that is due first, of hosts to which none is on its way; it is on its
  /// way until `tried` is called. None when `stop` is requested. Errors: io.
  std::optional<Delivery> next_delivery(const std::stop_token& stop);
  /// A try of that is over. It is tried again after a pause, the longer the more often it was, and
  /// given up after `most_tries`, or at once when it `may_not` be made.
  enum class Try { taken, failed, may_not };
  void tried(const Delivery& delivery, Try how, std::chrono::milliseconds first_pause);
  Told told() const;

  /// What an owner's jobs that have ended and its assets take on the disk [bytes].
  std::uint64_t bytes_of(std::string_view owner) const;
  /// Notes whose an asset is that has arrived.
  void add_asset(const std::string& name, const std::string& owner, std::uint64_t bytes);
  std::optional<std::string> owner_of(std::string_view asset) const;
  /// Calls `remove` unless a job that waits or runs names the asset, or one did after `since`, or
  /// it came after that. Whether it did.
  bool release(std::string_view asset, std::optional<Time> since,
               const std::function<void()>& remove);

 private:
  struct Entry {
    Job job;
    Pace pace;
    bool saved = true;  // what the job is, once it has ended
    std::stop_source stop;
  };

  void lock_data();
  void sweep();
  Submitted replay(const Job& first, const std::string& fingerprint) const;
  void work(const std::stop_token& stop);
  void remove_old(const std::stop_token& stop);
  void sweep_assets();
  void count_bytes(std::string_view id);
  std::optional<Submitted> refusal(const Request& request) const;
  std::shared_ptr<Entry> next(const std::stop_token& stop);
  void run(Entry& entry, const std::stop_token& stop);
  void save_end(Entry& entry, const std::stop_token& stop);
  std::filesystem::path base_of(const Job& job) const;
  bool end(Job& job, Status status);
  bool save(const Job& job);
  std::optional<Delivery> delivery_of(const Job& job) const;
  std::filesystem::path folder(std::string_view id) const;

  const Settings settings_;
  const Engine engine_;
  std::shared_ptr<const int> lock_;  // descriptor that keeps other processes away
  mutable std::mutex mutex_;         // guards all below
  std::condition_variable_any changed_, left_;
  std::condition_variable_any owed_;
  std::set<std::string> called_;  // hosts to which a callback is on its way
  Told told_;
  std::unique_ptr<Store> store_;
  std::map<std::string, std::shared_ptr<Entry>, std::less<>> running_;  // and what they become
  std::vector<std::jthread> workers_;  // and who removes old jobs; last: the first to go
};

}  // namespace hoodoo::job
