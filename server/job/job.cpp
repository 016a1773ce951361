#include "server/job/job.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "server/job/state.hpp"

namespace hoodoo::job {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_state = 64u << 20;  // [bytes] of job.json and scene.json

Time now() {
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

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

bool has_ended(Status status) { return status != Status::accepted && status != Status::running; }

Settings checked(Settings settings) {
  for (auto& root : settings.roots) {
    std::error_code error;
    const auto real = fs::canonical(root, error);
    if (error || !fs::is_directory(real)) {
      throw Error(Fault::not_found, root.string(), "is no folder to read elevations from");
    }
    root = real;
  }
  std::error_code error;
  for (const auto* part : {"jobs", "assets"}) fs::create_directories(settings.data / part, error);
  if (error) throw Error(Fault::io, settings.data.string(), "cannot be made: " + error.message());
  settings.data = fs::canonical(settings.data);
  // A job names files below the roots only; this one is empty.
  if (settings.roots.empty()) settings.roots.push_back(settings.data / "assets");
  return settings;
}

}  // namespace

bool is_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == text.npos;
}

struct Queue::Entry {
  Job job;
  std::stop_source stop;
  bool active = false;  // a bake writes into its folder
};

Queue::Queue(Settings settings, Engine engine)
    : settings_(checked(std::move(settings))), engine_(std::move(engine)) {
  lock_data();
  load();
  worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

Queue::~Queue() = default;

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

void Queue::load() {
  for (const auto& item : fs::directory_iterator(settings_.data / "jobs")) {
    const auto id = item.path().filename().string();
    if (!is_id(id)) continue;
    if (!fs::exists(item.path() / "job.json")) {  // killed while it was made or removed
      fs::remove_all(item.path());
      continue;
    }
    auto entry = std::make_shared<Entry>();
    entry->job = from_text(id, read_file(item.path() / "job.json", most_state));
    last_serial_ = std::max(last_serial_, entry->job.serial);
    entries_[id] = std::move(entry);
  }
}

scene::Sources Queue::sources(const nlohmann::json& scene) const {
  scene::Sources best{settings_.roots.front(), settings_.roots};
  if (settings_.roots.size() == 1) return best;
  auto fewest = std::numeric_limits<std::size_t>::max();
  for (const auto& root : settings_.roots) {
    const auto found = engine_.check(scene, {root, settings_.roots}).size();
    if (found < fewest) best.base = root;
    fewest = std::min(fewest, found);
  }
  return best;
}

std::optional<Job> Queue::submit(const nlohmann::json& scene) {
  auto problems = engine_.check(scene, sources(scene));
  if (!problems.empty()) throw Error(Fault::bad_input, std::move(problems));
  auto entry = std::make_shared<Entry>();
  auto& job = entry->job;
  job.id = new_id();
  if (scene.contains("name") && scene["name"].is_string()) job.name = scene["name"];
  job.created = job.updated = now();
  write_file(folder(job.id) / "scene.json", scene.dump());

  const std::lock_guard guard(mutex_);
  const auto waiting = std::ranges::count_if(
      entries_, [](const auto& held) { return held.second->job.status == Status::accepted; });
  if (static_cast<std::size_t>(waiting) >= settings_.most_waiting) {
    fs::remove_all(folder(job.id));
    return std::nullopt;
  }
  job.serial = ++last_serial_;
  write_file(folder(job.id) / "job.json", to_text(job));
  entries_[job.id] = entry;
  changed_.notify_all();
  return job;
}

std::optional<Job> Queue::find(std::string_view id) const {
  const std::lock_guard guard(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  return found->second->job;
}

std::vector<Job> Queue::list() const {
  std::vector<Job> jobs;
  {
    const std::lock_guard guard(mutex_);
    for (const auto& held : entries_) jobs.push_back(held.second->job);
  }
  std::ranges::sort(jobs, std::ranges::greater{}, &Job::serial);
  return jobs;
}

std::optional<Job> Queue::dismiss(std::string_view id) {
  std::unique_lock guard(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  const auto entry = found->second;
  if (!has_ended(entry->job.status)) {
    end(*entry, Status::dismissed);
    const auto job = entry->job;
    guard.unlock();  // what runs on a stop request may report progress
    entry->stop.request_stop();
    return job;
  }
  if (entry->active) return entry->job;
  entries_.erase(found);
  guard.unlock();
  // Without its state file a folder is swept when the data is opened next.
  std::error_code ignored;
  fs::remove(folder(entry->job.id) / "job.json", ignored);
  fs::remove_all(folder(entry->job.id), ignored);
  return entry->job;
}

std::filesystem::path Queue::folder(std::string_view id) const {
  return settings_.data / "jobs" / id;
}
std::filesystem::path Queue::tileset(std::string_view id) const { return folder(id) / "out"; }

void Queue::work(const std::stop_token& stop) {
  while (const auto entry = next(stop)) {
    run(*entry, stop);
    const std::lock_guard guard(mutex_);
    entry->active = false;
  }
}

/// Waits for a job and marks it running; null when the queue stops.
std::shared_ptr<Queue::Entry> Queue::next(const std::stop_token& stop) {
  std::shared_ptr<Entry> first;
  std::unique_lock guard(mutex_);
  const auto find_first = [&] {
    for (const auto& held : entries_) {
      const auto& entry = held.second;
      if (entry->job.status != Status::accepted) continue;
      if (!first || entry->job.serial < first->job.serial) first = entry;
    }
    return first != nullptr;
  };
  if (!changed_.wait(guard, stop, find_first) || stop.stop_requested()) return nullptr;
  first->active = true;
  first->job.status = Status::running;
  first->job.updated = now();
  if (!first->job.started) first->job.started = first->job.updated;
  save(first->job);
  return first;
}

/// Bakes one job. A job that the queue's own stop interrupts keeps its status on disk.
void Queue::run(Entry& entry, const std::stop_token& stop) {
  const std::stop_callback forward(stop, [&entry] { entry.stop.request_stop(); });
  const auto home = folder(entry.job.id);
  const auto fail = [&](Fault fault, std::vector<Problem> problems) {
    const std::lock_guard guard(mutex_);
    if (entry.job.status != Status::running || stop.stop_requested()) return;
    entry.job.fault = fault;
    entry.job.problems = std::move(problems);
    entry.active = false;
    end(entry, Status::failed);
  };
  try {
    const auto scene = parse_json(read_file(home / "scene.json", most_state), "scene.json");
    bake::Settings settings;
    settings.threads = settings_.threads;
    settings.memory = settings_.memory;
    settings.cache = settings_.cache;
    settings.stop = entry.stop.get_token();
    settings.live_index = std::chrono::milliseconds(500);
    settings.progress = [&](const bake::Progress& progress) {
      const std::lock_guard guard(mutex_);
      entry.job.progress = progress;
      entry.job.updated = now();
    };
    auto report = engine_.bake(scene, sources(scene), home / "out", settings);
    const std::lock_guard guard(mutex_);
    if (entry.job.status != Status::running) return;
    entry.job.progress = report.progress;
    entry.job.warnings = std::move(report.warnings);
    entry.job.complete = report.complete;
    entry.active = false;
    end(entry, Status::successful);
  } catch (const Error& error) {
    fail(error.fault, error.problems);
  } catch (const std::exception& error) {
    fail(Fault::internal, {{"", error.what()}});
  }
}

/// With the mutex held.
void Queue::end(Entry& entry, Status status) {
  entry.job.status = status;
  entry.job.updated = now();
  entry.job.finished = entry.job.updated;
  save(entry.job);
}

/// A state that cannot be written is the old one after a restart; the job is then baked again from
/// its finished tiles.
void Queue::save(const Job& job) const {
  try {
    write_file(folder(job.id) / "job.json", to_text(job));
  } catch (const Error& error) {
    fmt::print(stderr, "hoodoo: {}\n", error.what());
  }
}

}  // namespace hoodoo::job
