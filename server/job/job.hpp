#pragma once
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/base/error.hpp"
#include "tiling/bake/bake.hpp"

/// server/job: queue and job state on disk.
namespace hoodoo::job {

enum class Status { accepted, running, successful, failed, dismissed };
using Time = std::chrono::sys_time<std::chrono::milliseconds>;

/// What is known of one job.
struct Job {
  std::string id;            // 32 lower-case hexadecimal digits
  std::uint64_t serial = 0;  // order of submission
  Status status = Status::accepted;
  std::string name;  // of the scene
  Time created{}, updated{};
  std::optional<Time> started, finished;
  bake::Progress progress;
  std::vector<std::string> warnings;  // oddities of the scene and the bake
  bool complete = false;              // every planned tile is there
  std::optional<Fault> fault;         // why it failed
  std::vector<Problem> problems;      // empty unless it failed
};

/// The two functions a queue needs of the stages below it.
struct Engine {
  std::function<std::vector<Problem>(const nlohmann::json& scene, const scene::Sources&)> check;
  std::function<bake::Report(const nlohmann::json& scene, const scene::Sources&,
                             const std::filesystem::path& folder, const bake::Settings&)>
      bake;
};

struct Settings {
  std::filesystem::path data;                // state; made when absent
  std::filesystem::path cache;               // finished tiles shared with others; empty: none
  std::vector<std::filesystem::path> roots;  // where a scene may find files
  int threads = 1;
  std::size_t memory = std::size_t{1024} << 20;  // [bytes] of one bake
  std::size_t most_waiting = 100;                // jobs accepted but not started
};

/// Jobs in the order they came, baked one at a time by a thread of the queue.
///
/// A job lives in data/jobs/ID: scene.json, job.json (written on every change of status) and the
/// tileset in out/. A queue on the same data takes up what an earlier one, stopped or killed,
/// did not finish: the bake continues from its finished tiles. One process at a time may use
/// the data. Every member may be called from any thread.
class Queue {
 public:
  /// Errors: not_found (a root), io (the data cannot be used, or another process does).
  Queue(Settings settings, Engine engine);
  /// Stops a bake that is running; its job continues when the next queue opens the data.
  ~Queue();
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// Takes a scene that has no problems; none when too many jobs are waiting. A relative path in
  /// the scene counts from the first root under which the scene has the fewest problems; without
  /// a root, no file can be named.
  /// Errors: bad_input with every problem and its pointer into the scene; limit, io.
  std::optional<Job> submit(const nlohmann::json& scene);

  std::optional<Job> find(std::string_view id) const;
  std::vector<Job> list() const;  // newest first

  /// Cancels a job that waits or runs; removes one that has ended, with its tiles. What it was, or
  /// none if there is no such job.
  std::optional<Job> dismiss(std::string_view id);

  /// Where the tileset of a job is written. The id must be that of a job.
  std::filesystem::path tileset(std::string_view id) const;

 private:
  struct Entry;

  void lock_data();
  void load();
  scene::Sources sources(const nlohmann::json& scene) const;
  void work(const std::stop_token& stop);
  std::shared_ptr<Entry> next(const std::stop_token& stop);
  void run(Entry& entry, const std::stop_token& stop);
  void end(Entry& entry, Status status);
  void save(const Job& job) const;
  std::filesystem::path folder(std::string_view id) const;

  const Settings settings_;
  const Engine engine_;
  std::shared_ptr<const int> lock_;  // descriptor that keeps other processes away
  mutable std::mutex mutex_;         // guards all below
  std::condition_variable_any changed_;
  std::map<std::string, std::shared_ptr<Entry>, std::less<>> entries_;
  std::uint64_t last_serial_ = 0;
  std::jthread worker_;  // last: the first to go
};

/// True for what `Queue` gives as id.
bool is_id(std::string_view text);

}  // namespace hoodoo::job
