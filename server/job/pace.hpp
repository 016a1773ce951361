#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "server/job/job.hpp"

namespace hoodoo::job {

/// How fast the tiles of a bake have been finished of late, which tells how long the rest takes.
class Pace {
 public:
  /// What is left at `now` [s]; none while there is nothing to tell it from.
  std::optional<std::uint64_t> seconds_left(Time now, const bake::Progress& progress) {
    constexpr std::size_t most = 60;
    constexpr auto apart = std::chrono::seconds(1), least = std::chrono::seconds(2);
    const bool again = !looks_.empty() && progress.done < looks_.back().done;
    if (progress.phase != bake::Progress::Phase::tiles || again) looks_.clear();
    if (progress.phase != bake::Progress::Phase::tiles) return std::nullopt;
    if (looks_.empty() || now - looks_.back().when >= apart) {
      looks_.push_back({now, progress.done});
      if (looks_.size() > most) looks_.pop_front();
    }
    const auto span = now - looks_.front().when;
    const auto finished = progress.done - looks_.front().done;
    if (span < least || finished == 0 || progress.total < progress.done) return std::nullopt;
    const auto seconds = std::chrono::duration<double>(span).count() *
                         static_cast<double>(progress.total - progress.done) /
                         static_cast<double>(finished);
    return static_cast<std::uint64_t>(seconds + 0.5);
  }

 private:
  struct Look {
    Time when;
    std::uint64_t done;
  };
  std::deque<Look> looks_;  // oldest first
};

}  // namespace hoodoo::job
