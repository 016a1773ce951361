#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "server/http/entrance.hpp"
#include "server/http/message.hpp"

/// The socket side: the one place that knows the HTTP library.
namespace hoodoo::http {

/// What answers requests, from many threads.
struct Service {
  std::function<Response(Request)> answer;
  /// Of a head: its body is not read before `answer`, but by the response's `take`; empty: none is.
  std::function<bool(const Request&)> takes_bodies;
  /// Told of each answer that the listener gives by itself, before it is sent, with what is known
  /// of the request and when that came; empty: nobody is.
  std::function<void(Request, Response&, std::chrono::steady_clock::time_point since)> note;
};

/// Holds an address and answers requests there. Unread heads never reach the service, nor do bodies
/// over `most_body`, unless it takes them piece by piece; any other comes whole. A body that comes
/// slower than `least_rate` is cut off, and so is one that is under way when the server stops. What
/// would be answered later is then answered at once.
///
/// "Expect: 100-continue" is answered by 100 when the body is wanted, and else by what there is to
/// say without it. Of a body that is not wanted and comes all the same `most_passed_over` is read.
class Listener {
 public:
  /// Binds; port 0 takes any that is free. The address is not shared with another process.
  /// Errors: io.
  Listener(const std::string& host, int port, std::size_t most_connections = 4096);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }
  /// From any thread.
  ConnectionCounts connections() const;

  /// Answers until `stop`, then ends what was begun and returns. Errors: io.
  void run(const Service& service, const std::stop_token& stop);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
  int port_ = 0;
};

}  // namespace hoodoo::http
