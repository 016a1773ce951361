#include "server/job/queue.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "engine/base/file.hpp"
#include "engine/base/hash.hpp"
#include "engine/base/json.hpp"
#include "server/asset/assets.hpp"
#include "server/job/state.hpp"

namespace hoodoo::job {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_inputs = 64u << 20;  // [bytes]
constexpr auto removal_patience = std::chrono::seconds(2);

/// 128 random bits, so that an id cannot be guessed.
std::string new_id() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw Error(Fault::io, "", "the system gives no random bytes");
  }
  std::string id;
  for (const unsigned byte : bytes) id += fmt::format("{:02x}", byte);
  return id;
}

Settings checked(Settings settings) {
  std::error_code error;
  for (const auto* part : {"jobs", "checks"}) {
    fs::create_directories(settings.data / part, error);
    if (error) throw Error(Fault::io, settings.data.string(), "cannot be made: " + error.message());
  }
  settings.data = fs::canonical(settings.data);
  return settings;
}

/// Later than before even where the clock is not, so that whoever saw the job sees the change.
void touch(Job& job) { job.updated = std::max(now(), job.updated + std::chrono::milliseconds(1)); }

bool is_bake(const Request& request) { return request.process == bake_process; }

/// So that a new name in the folder outlives a power failure.
void sync_folder(const fs::path& folder) {
  const int held = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool well = held >= 0 && ::fsync(held) == 0;
  const int why = errno;
  if (held >= 0) ::close(held);
  if (well) return;
  throw Error(Fault::io, folder.string(),
              "cannot be written to disk: " + std::generic_category().message(why));
}

/// Of all that makes a request this one.
std::string fingerprint_of(const Request& request) {
  auto text =
      request.process + " " + std::to_string(request.priority) + " " + request.inputs.dump();
  const auto& [success, in_progress, failed] = request.subscriber;
  if (!request.subscriber.empty()) text += " " + success + " " + in_progress + " " + failed;
  for (const auto& output : request.outputs) text += " " + output;
  return sha256(text).hex();
}

/// Names of assets anywhere in the texts of `inputs`, and perhaps more.
std::vector<std::string> assets_named(const nlohmann::json& inputs) {
  constexpr std::size_t length = 7 + 64;
  std::vector<std::string> names;
  if (inputs.is_structured()) {
    for (const auto& item : inputs) {
      std::ranges::move(assets_named(item), std::back_inserter(names));
    }
  }
  if (!inputs.is_string()) return names;
  const auto& text = inputs.get_ref<const std::string&>();
  for (auto at = text.find("sha256-"); at != text.npos; at = text.find("sha256-", at + 1)) {
    const auto name = text.substr(at, length);
    if (asset::digest_of(name)) names.push_back(name);
  }
  return names;
}

/// A file that is gone with its holder.
struct Scratch {
  fs::path path;
  explicit Scratch(fs::path path_) : path(std::move(path_)) {}
  ~Scratch() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

}  // namespace

Queue::Queue(Settings settings, Engine engine)
    : settings_(checked(std::move(settings))), engine_(std::move(engine)) {
  lock_data();
  store_ = std::make_unique<Store>(settings_.data / "jobs.db");
  store_->interrupt_all();
  sweep();
  if (!settings_.announce) store_->drop_deliveries();
  for (int i = 0; i < settings_.at_once; ++i) {
    workers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }
  if (settings_.keep.count() > 0) {
    workers_.emplace_back([this](const std::stop_token& stop) { remove_old(stop); });
  }
}

Queue::~Queue() {
  for (auto& worker : workers_) worker.request_stop();
}

void Queue::lock_data() {
  const auto path = settings_.data / "lock";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) throw Error(Fault::io, path.string(), "cannot be opened");
  lock_ = std::shared_ptr<const int>(new int(file), [](const int* held) {
    ::close(*held);
    delete held;
  });
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    throw Error(Fault::io, settings_.data.string(), "is in use by another server");
  }
}

std::vector<Problem> Queue::check(const nlohmann::json& scene) const {
  const Scratch file(settings_.data / "checks" / (new_id() + ".json"));
  write_file(file.path, scene.dump());
  return engine_.check(file.path);
}

Submitted Queue::replay(const Job& first, const std::string& fingerprint) const {
  if (first.fingerprint != fingerprint) return {Submitted::Kind::key_reused, {}};
  const auto live = running_.find(first.id);
  return {Submitted::Kind::replayed, live == running_.end() ? first : live->second->job};
}

/// Why no more jobs of this owner are taken. With the mutex held.
std::optional<Submitted> Queue::refusal(const Request& request) const {
  using Kind = Submitted::Kind;
  const auto left = asset::left_on_disk(settings_.data);
  if (left < settings_.free_space) {
    throw Error(Fault::io, "",
                fmt::format("the disk has {}: {} bytes are left, and {} are kept free",
                            asset::no_space, left, settings_.free_space));
  }
  const auto waiting = store_->count(Status::accepted);
  if (waiting >= settings_.most_waiting) return Submitted{Kind::queue_full, {}};
  const auto& quota = request.quota;
  auto own = store_->count(Status::accepted, request.owner);
  if (quota.jobs) own += store_->count(Status::running, request.owner);
  const auto most = quota.jobs.value_or(settings_.most_of_owner);
  if (own >= most) return Submitted{Kind::owner_full, {}, own, most};
  if (!quota.bytes) return std::nullopt;
  const auto bytes = store_->bytes_of(request.owner);
  if (bytes < *quota.bytes) return std::nullopt;
  return Submitted{Kind::owner_space, {}, bytes, *quota.bytes};
}

Submitted Queue::submit(const Request& request) {
  Job job;
  job.process = request.process;
  job.owner = request.owner;
  job.key = request.key;
  job.priority = request.priority;
  job.subscriber = request.subscriber;
  job.bounds = request.quota.bake;
  job.outputs = request.outputs;
  job.fingerprint = fingerprint_of(request);
  if (!job.key.empty()) {
    const std::lock_guard guard(mutex_);
    const auto first = store_->find_key(job.owner, job.key);
    if (first && holds_key(first->status)) {
      return replay(*first, job.fingerprint);
    }
  }
  if (is_bake(request)) {
    auto problems = check(request.inputs.at("scene"));
    if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
    const auto& scene = request.inputs.at("scene");
    if (scene.contains("name") && scene["name"].is_string()) job.name = scene["name"];
  }
  job.id = new_id();
  job.created = job.updated = now();
  const auto assets = assets_named(request.inputs);
  const std::lock_guard guard(mutex_);
  if (auto refused = refusal(request)) return std::move(*refused);
  const auto home = folder(job.id);
  try {
    if (is_bake(request)) {
      write_file(home / "scene.json", request.inputs.at("scene").dump());
      if (const auto base = request.inputs.find("base"); base != request.inputs.end()) {
        write_file(home / "base", base->get<std::string>());
      }
    } else {
      write_file(home / "inputs.json", request.inputs.dump());
    }
    sync_folder(home);
    sync_folder(home.parent_path());
    if (!store_->insert(job, assets)) {  // the same key came at the same time
      fs::remove_all(home);
      return replay(store_->find_key(job.owner, job.key).value(), job.fingerprint);
    }
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(home, ignored);
    throw;
  }
  changed_.notify_one();
  return {Submitted::Kind::taken, job};
}

std::optional<Job> Queue::find(std::string_view id) const {
  if (!is_id(id)) return std::nullopt;
  const std::lock_guard guard(mutex_);
  const auto live = running_.find(id);
  return live == running_.end() ? store_->find(id) : live->second->job;
}

std::vector<Job> Queue::list(const Filter& filter) const {
  const std::lock_guard guard(mutex_);
  auto jobs = store_->list(filter, now());
  for (auto& job : jobs) {
    const auto live = running_.find(job.id);
    if (live != running_.end()) job = live->second->job;
  }
  return jobs;
}

std::size_t Queue::count(Status status) const {
  const std::lock_guard guard(mutex_);
  return store_->count(status);
}

bool Queue::is_full() const { return count(Status::accepted) >= settings_.most_waiting; }

std::optional<Job> Queue::dismiss(std::string_view id) {
  if (!is_id(id)) return std::nullopt;
  std::unique_lock guard(mutex_);
  if (const auto live = running_.find(id); live != running_.end()) {
    const auto entry = live->second;
    if (!has_ended(entry->job.status)) {
      entry->saved = end(entry->job, Status::dismissed);
      auto job = entry->job;
      guard.unlock();  // what runs on a stop request may report progress
      entry->stop.request_stop();
      return job;
    }
    if (!left_.wait_for(guard, removal_patience, [&] { return !running_.contains(id); })) {
      return entry->job;
    }
  }
  auto job = store_->find(id);
  if (!job) return std::nullopt;
  if (!has_ended(job->status)) {
    end(*job, Status::dismissed);
    return job;
  }
  store_->remove(id);
  guard.unlock();
  // Without its row a folder is swept when the data is opened next.
  std::error_code ignored;
  fs::remove_all(folder(id), ignored);
  return job;
}

fs::path Queue::folder(std::string_view id) const { return settings_.data / "jobs" / id; }
fs::path Queue::results(std::string_view id) const { return folder(id) / "out"; }

void Queue::work(const std::stop_token& stop) {
  while (const auto entry = next(stop)) {
    run(*entry, stop);
    save_end(*entry, stop);
    count_bytes(entry->job.id);
    const std::lock_guard guard(mutex_);
    running_.erase(entry->job.id);
    left_.notify_all();
  }
}

/// Waits for a job and marks it running; null when the queue stops.
std::shared_ptr<Queue::Entry> Queue::next(const std::stop_token& stop) {
  std::unique_lock guard(mutex_);
  std::optional<Job> first;
  const auto find_first = [&] {
    first = store_->first_waiting();
    while (first && has_ended(first->status)) {  // its row is damaged
      if (!end(*first, Status::failed)) return false;
      first = store_->first_waiting();
    }
    return first.has_value();
  };
  if (!changed_.wait(guard, stop, find_first) || stop.stop_requested()) return nullptr;
  auto entry = std::make_shared<Entry>();
  entry->job = std::move(*first);
  auto& job = entry->job;
  job.status = Status::running;
  touch(job);
  if (!job.started) job.started = job.updated;
  save(job);
  running_[job.id] = entry;
  return entry;
}

/// Carries out one job. What the queue's own stop interrupts waits again at the next start.
void Queue::run(Entry& entry, const std::stop_token& stop) {
  const std::stop_callback forward(stop, [&entry] { entry.stop.request_stop(); });
  const auto fail = [&](Fault fault, std::vector<Problem> problems) {
    const std::lock_guard guard(mutex_);
    if (entry.job.status != Status::running || stop.stop_requested()) return;
    entry.job.fault = fault;
    entry.job.problems = std::move(problems);
    entry.saved = end(entry.job, Status::failed);
  };
  try {
    Work work{entry.job.process, folder(entry.job.id),   {}, base_of(entry.job),
              entry.job.bounds,  entry.stop.get_token(), {}};
    if (work.process != bake_process) {
      work.inputs = parse_json(read_file(work.folder / "inputs.json", most_inputs), "inputs.json");
    }
    work.progress = [&](const bake::Progress& progress) {
      const std::lock_guard guard(mutex_);
      if (entry.job.status != Status::running) return;
      entry.job.outcome.progress = progress;
      entry.job.outcome.progress.finished.clear();
      touch(entry.job);
      hear(entry.job, progress.finished);
      entry.job.seconds_left = entry.pace.seconds_left(entry.job.updated, progress);
    };
    auto outcome = engine_.run(work);
    const std::lock_guard guard(mutex_);
    if (entry.job.status != Status::running) return;
    entry.job.outcome = std::move(outcome);
    entry.saved = end(entry.job, Status::successful);
  } catch (const Error& error) {
    fail(error.fault, error.problems);
  } catch (const std::exception& error) {
    fail(Fault::internal, {{"", error.what()}});
  }
}

/// With the mutex held.
bool Queue::end(Job& job, Status status) {
  job.status = status;
  job.seconds_left.reset();
  touch(job);
  job.finished = job.updated;
  return save(job);
}

/// What the subscriber of a job is owed for its new status.
std::optional<Delivery> Queue::delivery_of(const Job& job) const {
  const auto& [success, in_progress, failed] = job.subscriber;
  Delivery owed;
  owed.job = job.id;
  owed.due = job.updated;
  if (job.status == Status::running) {
    owed.event = Event::in_progress;
    owed.uri = in_progress;
  } else if (job.status == Status::successful) {
    owed.event = Event::success;
    owed.uri = success;
  } else if (job.status == Status::failed) {
    owed.event = Event::failed;
    owed.uri = failed;
  }
  if (owed.uri.empty()) return std::nullopt;
  owed.body = settings_.announce(job, results(job.id));
  return owed;
}

/// A state that cannot be written is the old one after a restart; the job is then carried out
/// again from what it has finished.
bool Queue::save(const Job& job) {
  try {
    const auto owed = settings_.announce ? delivery_of(job) : std::nullopt;
    store_->update(job, owed);
    if (owed) owed_.notify_all();
    return true;
  } catch (const std::exception& error) {
    fmt::print(stderr, "hoodoo: {}\n", error.what());
    return false;
  }
}

}  // namespace hoodoo::job
