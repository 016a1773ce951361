#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/error.hpp"
#include "tiling/bake/bake.hpp"

/// server/job: jobs, their queue and their state on disk.
namespace hoodoo::job {

enum class Status { accepted, running, successful, failed, dismissed };
using Time = std::chrono::sys_time<std::chrono::milliseconds>;

/// What clients ask for and wait for.
inline constexpr std::string_view bake_process = "bake-terrain";
inline constexpr std::string_view analyze_process = "analyze-dem";
inline constexpr std::string_view diff_process = "diff-tilesets";

inline constexpr int most_priority = 10;  // and least, negative

/// Where a client wants to hear of its job (OGC API - Processes 1.0, callback): addresses, empty
/// for none.
struct Subscriber {
  std::string success, in_progress, failed;
  bool empty() const { return success.empty() && in_progress.empty() && failed.empty(); }
};

/// How large a bake may be; none: as large as it is.
struct Bounds {
  std::optional<std::uint64_t> tiles;  // planned
  std::optional<double> extent;        // largest side of the world [m]
};

/// What one owner may use; none: as much as there is.
struct Quota {
  std::optional<std::uint64_t> jobs;   // waiting and running
  std::optional<std::uint64_t> bytes;  // on the disk: its jobs that have ended, its assets
  Bounds bake;                         // each of its bakes
};

/// What a client asks for.
struct Request {
  std::string process;
  nlohmann::json inputs;  // checked by whoever made the request
  int priority = 0;       // the larger the sooner, in [-most_priority, most_priority]
  std::string owner;      // whose it is; empty where nobody has a name
  std::string key;        // two requests of one owner with one key are one; empty: none
  Subscriber subscriber{};
  Quota quota{};                       // of the owner
  std::vector<std::string> outputs{};  // names of those that are wanted; empty: all
};

/// What a job has made.
struct Outcome {
  bake::Progress progress;
  std::vector<std::string> warnings;  // oddities of the scene and the bake
  bool complete = false;              // every planned tile is there
  /// Of processes that are no bake; else null. May be large: what finds or lists jobs that have
  /// ended leaves it out, see Queue::report.
  std::shared_ptr<const nlohmann::json> report;
};

/// Of the tiles that a bake finishes so many are told at most, the newest.
inline constexpr std::size_t most_told = 256;

/// A tile and when it was heard of.
struct HeardTile {
  bake::FinishedTile tile;
  Time when;
};

/// What is known of one job.
struct Job {
  std::string id;            // 32 lower-case hexadecimal digits
  std::uint64_t serial = 0;  // order of submission
  Status status = Status::accepted;
  std::string process{bake_process};
  std::string owner, key;
  std::string fingerprint;  // of the request that `key` came with
  int priority = 0;
  std::string name;                  // of the scene
  std::vector<std::string> outputs;  // as of the request
  Subscriber subscriber;
  Bounds bounds;
  Time created{}, updated{};  // `updated` grows with every change that can be seen
  std::optional<Time> started, finished;
  std::optional<std::uint64_t> seconds_left;             // an estimate, while its tiles are baked
  std::shared_ptr<const std::vector<HeardTile>> newest;  // tiles of a running bake; null: none
  Outcome outcome;
  std::optional<Fault> fault;     // why it failed
  std::vector<Problem> problems;  // empty unless it failed
};

inline bool has_ended(Status status) {
  return status != Status::accepted && status != Status::running;
}

/// Whether what came with a job's key is that job when it comes again, and no new one.
inline bool holds_key(Status status) {
  return status != Status::failed && status != Status::dismissed;
}

inline Time now() {
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

/// True for what `Queue` gives as id.
inline bool is_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == text.npos;
}

}  // namespace hoodoo::job
