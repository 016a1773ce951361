#include "server/job/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>

#include "engine/base/error.hpp"

namespace hoodoo::job {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int no_program = 127;  // as the shell has it
constexpr int less_urgent = 5;   // added to the niceness
constexpr std::size_t longest_line = 1u << 20;

/// A descriptor that is closed with its holder.
struct Descriptor {
  int number = -1;
  Descriptor() = default;
  explicit Descriptor(int number_) : number(number_) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

struct Pipe {
  Descriptor read, write;
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw Error(Fault::io, "", std::strerror(errno));
    read.number = ends[0];
    write.number = ends[1];
  }
};

/// The hard limit stands `grace` above the soft one.
void limit(__rlimit_resource what, rlim_t most, rlim_t grace = 0) {
  const rlimit both{most, most + grace};
  ::setrlimit(what, &both);
}

/// Between fork and exec, where only functions that are safe in a signal handler may be called.
[[noreturn]] void become(char* const* arguments, const Limits& limits, pid_t parent, int output,
                         int errors) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(no_program);  // it died before that
  ::setpgid(0, 0);  // Ctrl-C on a terminal is for the server, which then stops its children
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  std::signal(SIGPIPE, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  if (limits.memory > 0) limit(RLIMIT_DATA, limits.memory);
  // At the soft limit SIGXCPU tells why; at the hard one comes SIGKILL.
  const auto seconds = static_cast<rlim_t>(limits.processor.count());
  if (seconds > 0) limit(RLIMIT_CPU, seconds, 5);
  errno = 0;
  [[maybe_unused]] const int nice = ::nice(less_urgent);
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(errors, STDERR_FILENO);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  ::execv(arguments[0], arguments);
  ::_exit(no_program);
}

/// Cuts what arrives into lines.
class Lines {
 public:
  explicit Lines(const std::function<void(std::string_view)>& on_line) : on_line_(on_line) {}
  void add(std::string_view text) {
    waiting_ += text;
    for (auto end = waiting_.find('\n'); end != waiting_.npos; end = waiting_.find('\n')) {
      give(waiting_.substr(0, end));
      waiting_.erase(0, end + 1);
    }
    if (waiting_.size() > longest_line) waiting_.clear();
  }
  std::string last() {
    if (!waiting_.empty()) give(waiting_);
    return last_;
  }

 private:
  void give(std::string line) {
    if (line.empty()) return;
    if (on_line_) on_line_(line);
    last_ = std::move(line);
  }
  const std::function<void(std::string_view)>& on_line_;
  std::string waiting_, last_;
};

/// Reads once; false at the end.
template <class Use>
bool read_some(Descriptor& from, const Use& use) {
  std::array<char, 1 << 16> piece;
  const auto got = ::read(from.number, piece.data(), piece.size());
  if (got < 0 && (errno == EINTR || errno == EAGAIN)) return true;
  if (got > 0) use(std::string_view(piece.data(), static_cast<std::size_t>(got)));
  if (got <= 0) from.close();
  return got > 0;
}

/// Collects what the child says until it closes both of its ends, stopping it when asked.
void listen(pid_t child, Pipe& output, Pipe& errors, const Descriptor& wake,
            const std::stop_token& stop, Lines& lines, Ended& ended) {
  std::optional<Clock::time_point> kill_at;
  bool killed = false;
  while (output.read.number >= 0 || errors.read.number >= 0) {
    if (stop.stop_requested() && !kill_at) {
      ended.stopped = true;
      ::kill(-child, SIGTERM);
      kill_at = Clock::now() + stop_patience;
    }
    int patience = -1;
    if (kill_at && !killed) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(*kill_at - Clock::now());
      patience = static_cast<int>(std::max<std::int64_t>(0, left.count()));
      if (patience == 0) {
        ::kill(-child, SIGKILL);
        killed = true;
        patience = -1;
      }
    }
    std::array<pollfd, 3> waited{{{output.read.number, POLLIN, 0},
                                  {errors.read.number, POLLIN, 0},
                                  {kill_at ? -1 : wake.number, POLLIN, 0}}};
    if (::poll(waited.data(), waited.size(), patience) <= 0) continue;
    if (waited[0].revents != 0) {
      read_some(output.read, [&](std::string_view text) {
        if (ended.output.size() < most_output) ended.output += text;
      });
    }
    if (waited[1].revents != 0) {
      read_some(errors.read, [&](std::string_view text) { lines.add(text); });
    }
  }
}

}  // namespace

Ended run_child(const std::vector<std::string>& arguments, const Limits& limits,
                const std::stop_token& stop,
                const std::function<void(std::string_view line)>& on_line) {
  std::vector<char*> words;
  for (const auto& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  Pipe output, errors;
  const Descriptor wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  const auto parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw Error(Fault::io, "", std::string("no process: ") + std::strerror(errno));
  if (child == 0) become(words.data(), limits, parent, output.write.number, errors.write.number);
  ::setpgid(child, child);  // whoever of the two comes first
  output.write.close();
  errors.write.close();
  Ended ended;
  Lines lines(on_line);
  {
    const std::stop_callback ring(stop, [&wake] { ::eventfd_write(wake.number, 1); });
    listen(child, output, errors, wake, stop, lines, ended);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  ended.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  ended.last_line = lines.last();
  if (ended.code == no_program) {
    throw Error(Fault::not_found, arguments.front(), "cannot be run");
  }
  return ended;
}

}  // namespace hoodoo::job
