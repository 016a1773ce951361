#include "server/signals.hpp"

#include <unistd.h>

#include <csignal>

namespace hoodoo {
namespace {

constexpr int cancelled_exit = 130;

sigset_t waited_for() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR2);  // the destructor's own
  return set;
}

}  // namespace

Signals::Signals() {
  const sigset_t set = waited_for();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  waiter_ = std::jthread([this] {
    const sigset_t waited = waited_for();
    for (int signal = 0; sigwait(&waited, &signal) == 0 && signal != SIGUSR2;) {
      if (source_.stop_requested()) _exit(cancelled_exit);
      source_.request_stop();
    }
  });
}

Signals::~Signals() { pthread_kill(waiter_.native_handle(), SIGUSR2); }

}  // namespace hoodoo
