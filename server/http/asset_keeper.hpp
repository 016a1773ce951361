#pragma once
#include <chrono>
#include <stop_token>
#include <thread>

#include "server/asset/assets.hpp"
#include "server/job/queue.hpp"

namespace hoodoo::http {

/// Removes assets that no job has used for `keep`, nor anybody sent, in a thread of its own until
/// it goes. One that a job names which waits or runs stays. 0: removes none.
class AssetKeeper {
 public:
  AssetKeeper(job::Queue& queue, const asset::Assets& assets, std::chrono::seconds keep);

 private:
  void run(const std::stop_token& stop);
  void collect();

  job::Queue& queue_;
  const asset::Assets& assets_;
  const std::chrono::seconds keep_;
  std::jthread thread_;  // last: the first to go
};

}  // namespace hoodoo::http
