#pragma once
#include <chrono>
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
  /// Waits for a thread that is free; false when there is none in that time.
  bool wait_for_free(std::chrono::milliseconds patience);
  /// Returns when all connections have ended.
  void finish();

 private:
  void work();

  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable wanted_, freed_;
  std::list<std::function<void()>> waiting_;  // each has a free thread that will take it
  std::size_t threads_ = 0, free_ = 0;
  bool finishing_ = false;
};

/// Connections that wait for a request, in the order in which they began to.
class WaitingConnections {
 public:
  /// One of them, while it lives.
  class Turn {
   public:
    Turn(WaitingConnections& all, int socket);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    WaitingConnections& all_;
    std::list<int>::iterator at_;
  };

  /// Shuts down the one that has waited longest, so that its thread ends; false when none waits.
  bool end_oldest();

 private:
  std::mutex mutex_;
  std::list<int> sockets_;  // the longest first; -1: it has been ended
};

}  // namespace hoodoo::http
