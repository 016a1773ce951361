#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <system_error>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "server/asset/assets.hpp"
#include "server/job/queue.hpp"

/// What of its data a queue keeps, and who is told.
namespace hoodoo::job {
namespace {

namespace fs = std::filesystem;

/// Removes what a killed child left beside the files it had finished; what all the rest takes.
std::uint64_t tidy(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> leftovers;
  std::uint64_t bytes = 0;
  for (fs::recursive_directory_iterator item(folder, error), end; !error && item != end;
       item.increment(error)) {
    std::error_code gone;
    if (is_leftover(item->path())) {
      leftovers.push_back(item->path());
    } else if (item->is_regular_file(gone)) {
      const auto size = item->file_size(gone);
      if (!gone) bytes += size;
    }
  }
  for (const auto& path : leftovers) fs::remove(path, error);
  return bytes;
}

}  // namespace

/// Folders of jobs that were being made or removed when the server was killed.
void Queue::sweep() {
  std::vector<fs::path> gone;
  for (const auto& item : fs::directory_iterator(settings_.data / "jobs")) {
    const auto id = item.path().filename().string();
    if (is_id(id) && !store_->find(id)) gone.push_back(item.path());
  }
  for (const auto& item : fs::directory_iterator(settings_.data / "checks")) {
    gone.push_back(item.path());
  }
  for (const auto& path : gone) fs::remove_all(path);
  for (const auto& id : store_->uncounted()) count_bytes(id);
  sweep_assets();
}

/// The results of the bake that a job begins with, as long as they are kept.
fs::path Queue::base_of(const Job& job) const {
  const auto file = folder(job.id) / "base";
  std::error_code error;
  if (job.process != bake_process || !fs::exists(file, error)) return {};
  const auto base = read_file(file, 100);
  if (!is_id(base) || !fs::exists(results(base) / "bake.json", error)) return {};
  return results(base);
}

/// A disk that is full may have room again; until then the end of a job is known here alone.
void Queue::save_end(Entry& entry, const std::stop_token& stop) {
  std::unique_lock guard(mutex_);
  while (!entry.saved && !stop.stop_requested()) {
    left_.wait_for(guard, stop, std::chrono::seconds(1), [] { return false; });
    entry.saved = save(entry.job);
  }
}

/// Those that came, or went, while no queue looked.
void Queue::sweep_assets() {
  std::set<std::string> found;
  std::error_code error;
  for (const auto& item : fs::directory_iterator(settings_.data / "assets", error)) {
    const auto name = item.path().filename().string();
    const auto state = file_state(item.path());
    if (!state || !asset::digest_of(name)) continue;
    found.insert(name);
    store_->add_asset(name, "", state->bytes, Time(std::chrono::seconds(state->seconds)));
  }
  for (const auto& name : store_->assets()) {
    if (!found.contains(name)) store_->remove_asset(name);
  }
}

/// Of a job that nothing writes to any more. One that goes on later is counted again then.
void Queue::count_bytes(std::string_view id) {
  const auto bytes = tidy(folder(id));
  const std::lock_guard guard(mutex_);
  try {
    store_->set_bytes(id, bytes);
  } catch (const Error& error) {
    fmt::print(stderr, "hoodoo: {}\n", error.what());
  }
}

/// Dismisses jobs some time after they have ended, a few at a time, until the queue stops. A
/// callback that is owed keeps its job until it is settled.
void Queue::remove_old(const std::stop_token& stop) {
  const auto pause = std::clamp<std::chrono::seconds>(settings_.keep / 10, std::chrono::seconds(1),
                                                      std::chrono::minutes(1));
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any stopped;
  while (!stop.stop_requested()) {
    Filter old;
    old.limit = 100;
    old.ended_by = now() - settings_.keep;
    old.told = true;
    try {
      for (const auto& job : list(old)) dismiss(job.id);
    } catch (const Error& error) {
      fmt::print(stderr, "hoodoo: {}\n", error.what());
    }
    stopped.wait_for(lock, stop, pause, [] { return false; });
  }
}

std::optional<Delivery> Queue::next_delivery(const std::stop_token& stop) {
  using std::chrono::milliseconds;
  std::unique_lock guard(mutex_);
  std::optional<Delivery> first;
  const auto is_due = [&] {
    first = store_->first_delivery(called_);
    return first && first->due <= now();
  };
  while (!stop.stop_requested()) {
    if (is_due()) {
      called_.insert(host_of(first->uri));
      return first;
    }
    // The clock may be set meanwhile.
    milliseconds pause = std::chrono::minutes(1);
    std::optional<Time> known;
    if (first) {
      known = first->due;
      pause = std::clamp(*known - now(), milliseconds(1), pause);
    }
    // One that comes meanwhile may be due a little later than it came: then the pause is another.
    owed_.wait_for(guard, stop, pause,
                   [&] { return is_due() || (first && (!known || first->due < *known)); });
  }
  return std::nullopt;
}

void Queue::tried(const Delivery& delivery, Try how, std::chrono::milliseconds first_pause) {
  const int tries = delivery.tries + 1;
  const bool again = how == Try::failed && tries < most_tries;
  const std::lock_guard guard(mutex_);
  called_.erase(host_of(delivery.uri));
  owed_.notify_all();  // whoever waited for this host
  if (how == Try::taken) ++told_.delivered;
  if (how == Try::failed) ++told_.failed_tries;
  if (how != Try::taken && !again) ++told_.given_up;
  std::optional<Time> due;
  if (again) due = now() + pause_after(tries, first_pause);
  store_->tried(delivery, due);
}

Told Queue::told() const {
  const std::lock_guard guard(mutex_);
  auto told = told_;
  told.pending = store_->count_deliveries();
  return told;
}

std::shared_ptr<const nlohmann::json> Queue::report(std::string_view id) const {
  std::string text;
  {
    const std::lock_guard guard(mutex_);
    const auto live = running_.find(id);
    if (live != running_.end()) return live->second->job.outcome.report;
    text = store_->report(id);
  }
  // Apart from the lock, since it may take its time.
  if (text.empty()) return nullptr;
  try {
    return std::make_shared<const nlohmann::json>(parse_json(text, "the report of a job"));
  } catch (const Error& error) {
    throw Error(Fault::internal, std::string(id), error.what());
  }
}

std::uint64_t Queue::bytes_of(std::string_view owner) const {
  const std::lock_guard guard(mutex_);
  return store_->bytes_of(owner);
}

void Queue::add_asset(const std::string& name, const std::string& owner, std::uint64_t bytes) {
  const std::lock_guard guard(mutex_);
  store_->add_asset(name, owner, bytes, now());
}

std::optional<std::string> Queue::owner_of(std::string_view asset) const {
  const std::lock_guard guard(mutex_);
  return store_->owner_of(asset);
}

bool Queue::release(std::string_view asset, std::optional<Time> since,
                    const std::function<void()>& remove) {
  const std::lock_guard guard(mutex_);
  if (store_->is_used(asset)) return false;
  const auto last = store_->last_use(asset);
  if (since && last && *last > *since) return false;
  remove();
  store_->remove_asset(asset);
  return true;
}

}  // namespace hoodoo::job
