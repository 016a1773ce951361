#pragma once
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "server/http/message.hpp"

/// The socket side: the one place that knows the HTTP library.
namespace hoodoo::http {

/// Holds an address and answers requests there. Bodies over `most_body` and unread heads never
/// reach the handler; a body comes whole.
class Listener {
 public:
  /// Binds; port 0 takes any that is free. The address is not shared with another process.
  /// Errors: io.
  Listener(const std::string& host, int port);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }

  /// Calls `handler` from many threads until `stop`, then ends what was begun and returns.
  /// Errors: io.
  void run(const std::function<Response(Request)>& handler, const std::stop_token& stop);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
  int port_ = 0;
};

}  // namespace hoodoo::http
