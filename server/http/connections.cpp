#include "server/http/connections.hpp"

#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

namespace hoodoo::http {
namespace {

constexpr auto patience = std::chrono::seconds(10);  // of a thread that is free

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
    if (!wanted_.wait_for(lock, patience, called) || waiting_.empty()) break;
    auto serve = std::move(waiting_.front());
    waiting_.pop_front();
    --free_;
    lock.unlock();
    serve();
    serve = nullptr;
    lock.lock();
    ++free_;
  }
  --threads_, --free_;
  left_.notify_all();
}

void ConnectionThreads::finish() {
  std::unique_lock lock(mutex_);
  finishing_ = true;
  wanted_.notify_all();
  left_.wait(lock, [this] { return threads_ == 0; });
}

}  // namespace hoodoo::http
