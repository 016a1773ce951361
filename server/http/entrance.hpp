#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "server/http/connections.hpp"

namespace hoodoo::http {

/// Of a listener since it was made.
struct ConnectionCounts {
  std::size_t open = 0;        // now
  std::uint64_t accepted = 0;  // in all
  std::uint64_t dropped = 0;   // of them, those that waited for a request when others wanted in
  std::uint64_t slow = 0;      // of them, those cut off since they read too slowly
  std::uint64_t refused = 0;   // of them, those that were told so, since all others were at work
};

/// Takes connections from a listening socket and gives each a thread. Where there are too many, or
/// no descriptors left, the one goes that has waited longest for a request; while none waits,
/// whoever comes is refused. What comes is thereby never kept waiting by those who say nothing.
class Entrance {
 public:
  explicit Entrance(std::size_t most);
  ~Entrance();
  Entrance(const Entrance&) = delete;
  Entrance& operator=(const Entrance&) = delete;

  /// A wait for a request, which ends before the socket is closed.
  using Turn = std::shared_ptr<WaitingConnections::Turn>;
  using Serve = std::function<void(int socket, Turn first)>;
  using Refusal = std::function<std::string()>;

  /// `serve` owns its socket, on a thread of its own, and waits since it was accepted; `refusal`
  /// gives all that one hears that is refused. Returns when the listening socket is shut down after
  /// `stop`, and all have ended. Errors: io.
  void run(int listening, const Serve& serve, const Refusal& refusal, const std::stop_token& stop);

  WaitingConnections& waiting() { return waiting_; }
  void note_slow() { ++slow_; }
  ConnectionCounts counts() const;

 private:
  bool place(int socket, const Serve& serve);
  bool make_room();
  void refuse(int socket, const Refusal& refusal);
  void find_descriptor(int listening, const Refusal& refusal);

  WaitingConnections waiting_;
  int spare_;  // a descriptor to refuse with when there are no others; -1 when it is in use
  std::atomic<std::size_t> open_ = 0;
  std::atomic<std::uint64_t> accepted_ = 0, dropped_ = 0, slow_ = 0, refused_ = 0;
  ConnectionThreads threads_;  // its end waits for all that use the rest
};

}  // namespace hoodoo::http
