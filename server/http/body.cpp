#include "server/http/body.hpp"

#include <exception>

namespace hoodoo::http {

Received receive(const Pieces& pieces, const std::stop_token& stop, const UsePiece& use) {
  using Clock = std::chrono::steady_clock;
  constexpr auto least = least_rate * static_cast<std::size_t>(body_patience.count());
  auto end = Received::broken;
  auto idle_since = Clock::now(), refused_at = idle_since;
  Clock::duration waited{0};
  std::size_t came = 0, passed_over = 0;  // `came` while that was waited
  std::exception_ptr thrown;
  const bool whole = pieces([&](std::string_view piece) {
    waited += Clock::now() - idle_since;
    came += piece.size();
    if (stop.stop_requested()) {
      end = Received::stopped;
      return false;
    }
    if (waited >= body_patience) {
      if (came < least) {
        end = Received::slow;
        return false;
      }
      waited = {};
      came = 0;
    }
    if (end == Received::refused) {
      passed_over += piece.size();
      idle_since = Clock::now();
      return passed_over <= most_passed_over && idle_since - refused_at < body_patience;
    }
    try {
      if (!use(piece)) end = Received::refused;
    } catch (...) {
      thrown = std::current_exception();
      end = Received::refused;
    }
    idle_since = refused_at = Clock::now();
    return true;
  });
  if (thrown) std::rethrow_exception(thrown);
  if (whole && end == Received::broken) return Received::whole;
  const bool silent = end == Received::broken && Clock::now() - idle_since >= body_patience;
  return silent ? Received::slow : end;
}

}  // namespace hoodoo::http
