#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace hoodoo::job {

/// What a child process may use; 0 is without limit.
struct Limits {
  std::size_t memory = 0;             // [bytes] of data (RLIMIT_DATA)
  std::chrono::seconds processor{0};  // of all its threads together (RLIMIT_CPU)
};

/// How a child ended.
struct Ended {
  int code = 0;           // exit code, unless
  int signal = 0;         // it was killed by this one
  bool stopped = false;   // a stop was requested before it ended
  std::string output;     // its standard output, up to `most_output` bytes
  std::string last_line;  // of its standard error
};

inline constexpr std::size_t most_output = 16u << 20;  // [bytes]
/// A child that is told to stop (SIGTERM) has this long before it is killed.
inline constexpr std::chrono::milliseconds stop_patience{600};

/// Runs a program and waits for its end. `on_line` is called by this thread with every line of its
/// standard error. The child takes no input, leaves no core file, yields to this process, and is
/// killed when the calling thread or its process dies.
/// Errors: io when no process can be made; not_found when there is no such program.
Ended run_child(const std::vector<std::string>& arguments, const Limits& limits,
                const std::stop_token& stop,
                const std::function<void(std::string_view line)>& on_line);

}  // namespace hoodoo::job
