#pragma once
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/job/job.hpp"

namespace hoodoo::job {

/// What a subscriber may hear of a job.
enum class Event { in_progress, success, failed };

/// A callback that is owed. It stays in the outbox until it has been taken or is given up.
struct Delivery {
  std::string job;
  Event event = Event::success;
  std::string uri, body;
  int tries = 0;  // so far
  Time due{};     // when to try next
};

inline constexpr int most_tries = 6;

/// How long to wait after so many tries: `first`, and twice as long each time.
inline std::chrono::milliseconds pause_after(int tries, std::chrono::milliseconds first) {
  return first * (std::int64_t{1} << (tries - 1));
}

/// "HOST[:PORT]" of an address, in lower case.
std::string host_of(std::string_view uri);

/// The same each time it is tried, so that the receiver can tell.
std::string id_of(const Delivery& delivery);

}  // namespace hoodoo::job
