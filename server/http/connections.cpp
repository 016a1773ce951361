#include "server/http/connections.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

namespace hoodoo::http {
namespace {

constexpr auto idle_patience = std::chrono::seconds(10);  // of a thread that is free

}  // namespace

bool ConnectionThreads::run(std::function<void()> serve) {
  const std::lock_guard lock(mutex_);
  if (finishing_) return false;
  if (waiting_.size() == free_) {
    if (threads_ == most_) return false;
    try {
      std::thread([this] { work(); }).detach();  // counted, and waited for by `finish`
    } catch (const std::system_error&) {
      return false;  // the system has no more of them
    }
    ++threads_, ++free_;
  }
  waiting_.push_back(std::move(serve));
  wanted_.notify_one();
  return true;
}

void ConnectionThreads::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto called = [this] { return !waiting_.empty() || finishing_; };
    if (!wanted_.wait_for(lock, idle_patience, called) || waiting_.empty()) break;
    auto serve = std::move(waiting_.front());
    waiting_.pop_front();
    --free_;
    lock.unlock();
    serve();
    serve = nullptr;
    lock.lock();
    ++free_;
    freed_.notify_all();
  }
  --threads_, --free_;
  freed_.notify_all();
}

bool ConnectionThreads::wait_for_free(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return freed_.wait_for(lock, patience, [this] { return waiting_.size() < free_; });
}

void ConnectionThreads::finish() {
  std::unique_lock lock(mutex_);
  finishing_ = true;
  wanted_.notify_all();
  freed_.wait(lock, [this] { return threads_ == 0; });
}

WaitingConnections::Turn::Turn(WaitingConnections& all, int socket) : all_(all) {
  const std::lock_guard lock(all_.mutex_);
  at_ = all_.sockets_.insert(all_.sockets_.end(), socket);
}

WaitingConnections::Turn::~Turn() {
  const std::lock_guard lock(all_.mutex_);
  all_.sockets_.erase(at_);
}

bool WaitingConnections::end_oldest() {
  const std::lock_guard lock(mutex_);
  const auto oldest = std::ranges::find_if(sockets_, [](int socket) { return socket >= 0; });
  if (oldest == sockets_.end()) return false;
  ::shutdown(*oldest, SHUT_RDWR);  // still open: it is closed after its turn
  *oldest = -1;
  return true;
}

}  // namespace hoodoo::http
