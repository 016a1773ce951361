#pragma once
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>

namespace hoodoo::http {

/// A thread for each connection while it lives, so that one that dawdles keeps nobody waiting.
/// Threads that are free wait a while for the next one.
class ConnectionThreads {
 public:
  explicit ConnectionThreads(std::size_t most) : most_(most) {}
  ~ConnectionThreads() { finish(); }
  ConnectionThreads(const ConnectionThreads&) = delete;
  ConnectionThreads& operator=(const ConnectionThreads&) = delete;

  /// Calls `serve` on a thread; false when there are too many.
  bool run(std::function<void()> serve);
  /// Returns when all connections have ended.
  void finish();

 private:
  void work();

  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable wanted_, left_;
  std::list<std::function<void()>> waiting_;  // each has a free thread that will take it
  std::size_t threads_ = 0, free_ = 0;
  bool finishing_ = false;
};

}  // namespace hoodoo::http
