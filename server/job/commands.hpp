#pragma once
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "server/job/child.hpp"
#include "server/job/queue.hpp"

namespace hoodoo::job {

inline constexpr std::chrono::seconds most_processor_of_check{20};

/// How jobs are carried out by the `hoodoo` command in processes of their own, so that whatever
/// goes wrong with one, be it a crash, costs that job alone.
struct Commands {
  std::filesystem::path program;             // hoodoo
  std::filesystem::path cache;               // finished tiles shared with others; empty: none
  std::vector<std::filesystem::path> roots;  // where a scene may find files
  int threads = 1;
  std::size_t memory = std::size_t{1024} << 20;  // [bytes] that a bake plans with
  Limits limits;                                 // of any of them

  /// All problems of a scene in `file`; takes `most_processor_of_check` at most. Errors: as a
  /// bake's.
  std::vector<Problem> check(const std::filesystem::path& file) const;
  /// Carries out one job; goes on, twice at most, when its process is killed (SIGKILL). Errors: as
  /// the command tells them; limit when it ran into one of
  /// `limits`, internal when it crashed, cancelled.
  Outcome run(const Work& work) const;
};

}  // namespace hoodoo::job
