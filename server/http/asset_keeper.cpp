#include "server/http/asset_keeper.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>

#include "engine/base/file.hpp"
#include "server/http/log.hpp"

namespace hoodoo::http {

using std::chrono::seconds;

AssetKeeper::AssetKeeper(job::Queue& queue, const asset::Assets& assets, seconds keep)
    : queue_(queue), assets_(assets), keep_(keep) {
  if (keep.count() > 0) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void AssetKeeper::run(const std::stop_token& stop) {
  const auto pause = std::clamp<seconds>(keep_ / 10, seconds(1), std::chrono::minutes(1));
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any stopped;
  while (!stop.stop_requested()) {
    try {
      collect();
    } catch (const std::exception& error) {
      log_fault(std::string("assets: ") + error.what(), "");
    }
    stopped.wait_for(lock, stop, pause, [] { return false; });
  }
}

void AssetKeeper::collect() {
  const auto since = job::now() - keep_;
  for (const auto& name : assets_.list()) {
    const auto digest = asset::digest_of(name).value();
    // Of one that was put there by hand, or just now, the queue does not know.
    const auto state = file_state(assets_.file(digest));
    if (!state || job::Time(seconds(state->seconds)) > since) continue;
    queue_.release(name, since, [&] { assets_.remove(digest); });
  }
}

}  // namespace hoodoo::http
