#pragma once
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

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

/// Adds to the tiles of a job that are told, of which listeners have copies.
inline void hear(Job& job, const std::vector<bake::FinishedTile>& tiles) {
  if (tiles.empty()) return;
  auto newest = job.newest ? *job.newest : std::vector<HeardTile>();
  for (const auto& tile : tiles) newest.push_back({tile, job.updated});
  const auto over = std::max(newest.size(), most_told) - most_told;
  newest.erase(newest.begin(), newest.begin() + static_cast<std::ptrdiff_t>(over));
  job.newest = std::make_shared<const std::vector<HeardTile>>(std::move(newest));
}

}  // namespace hoodoo::job
