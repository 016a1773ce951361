#pragma once
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>

namespace hoodoo::bench {

inline double processor_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Medians of five runs each, the two in turn, so that both meet the same machine.
inline std::array<double, 2> median_seconds(const std::function<void()>& one,
                                            const std::function<void()>& other) {
  std::array<std::array<double, 5>, 2> all{};
  for (std::size_t run = 0; run < 5; ++run) {
    for (std::size_t which = 0; which < 2; ++which) {
      const double from = processor_seconds();
      (which == 0 ? one : other)();
      all[which][run] = processor_seconds() - from;
    }
  }
  for (auto& runs : all) std::sort(runs.begin(), runs.end());
  return {all[0][2], all[1][2]};
}

inline void rate(const char* what, double points, double seconds) {
  fmt::print("  {:56} {:9.1f} M points/s\n", what, points / seconds / 1e6);
}
inline void ratio(const char* what, double r, const char* goal) {
  fmt::print("{:58} {:9.2f}  (goal: {})\n", what, r, goal);
  std::fflush(stdout);
}

}  // namespace hoodoo::bench
