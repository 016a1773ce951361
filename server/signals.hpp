#pragma once
#include <stop_token>
#include <thread>

namespace hoodoo {

/// Turns SIGINT and SIGTERM into a stop request for as long as it lives; a second one ends the
/// process at once. Make it before any other thread, which then inherits the blocked signals.
class Signals {
 public:
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::jthread waiter_;
};

}  // namespace hoodoo
