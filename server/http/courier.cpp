#include "server/http/courier.hpp"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>

#include "server/http/log.hpp"
#include "server/job/state.hpp"

namespace hoodoo::http {

Courier::Courier(job::Queue& queue, Send send, std::chrono::milliseconds first_pause)
    : queue_(queue), send_(std::move(send)), first_pause_(first_pause) {
  for (int n = 0; n < at_once; ++n) {
    threads_.emplace_back([this](const std::stop_token& stop) { run(stop); });
  }
}

/// All of them together, since each may take a moment.
Courier::~Courier() {
  for (auto& thread : threads_) thread.request_stop();
}

void Courier::run(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any stopped;
  while (!stop.stop_requested()) {
    try {
      while (const auto delivery = queue_.next_delivery(stop)) deliver(*delivery, stop);
    } catch (const std::exception& error) {  // the jobs cannot be read or written
      log_fault(std::string("callbacks: ") + error.what(), "");
      stopped.wait_for(lock, stop, std::chrono::seconds(5), [] { return false; });
    }
  }
}

/// What the stop interrupts is tried again when the next server opens the data.
void Courier::deliver(const job::Delivery& delivery, const std::stop_token& stop) {
  using Try = job::Queue::Try;
  const auto from = std::chrono::steady_clock::now();
  Reply reply;
  try {
    reply = send_(delivery, stop);
  } catch (const std::exception& error) {
    reply.why = error.what();
  }
  if (reply.status == 0 && stop.stop_requested()) return;
  const bool taken = reply.status >= 200 && reply.status < 300;
  queue_.tried(delivery,
               taken           ? Try::taken
               : reply.may_not ? Try::may_not
                               : Try::failed,
               first_pause_);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - from;
  const int tries = delivery.tries + 1;
  log_callback({job::id_of(delivery), delivery.job, reply.why, reply.status, tries,
                !taken && (reply.may_not || tries == job::most_tries), took.count()});
}

}  // namespace hoodoo::http
