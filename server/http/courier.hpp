#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "server/http/callback_target.hpp"
#include "server/job/queue.hpp"

/// Callbacks to those who wait for a job.
namespace hoodoo::http {

/// How a try went.
struct Reply {
  int status = 0;        // of the answer; 0: there was none
  bool may_not = false;  // it was not made: the rules do not let it
  std::string why;       // there was no answer
};

/// "sha256=" and the HMAC-SHA256 of "TIMESTAMP.BODY" in hexadecimal.
std::string signature_of(const std::string& secret, const std::string& timestamp,
                         const std::string& body);

/// Reads the secret of signatures, without the end of its line.
/// Errors: not_found, io; bad_input when it is shorter than 16 characters.
std::string read_secret(const std::filesystem::path& file);

/// Posts callbacks: to hosts of the list alone, at the addresses that their names led to when they
/// were looked at, with no proxy and following no redirect. What is answered but for its status is
/// thrown away, and a try ends after ten seconds.
class Sender {
 public:
  Sender(AllowList allowed, std::string secret);
  Reply operator()(const job::Delivery& delivery, const std::stop_token& stop) const;

 private:
  AllowList allowed_;
  std::string secret_;
};

/// Delivers what the queue owes, a few at a time but to each host one after the other, in threads
/// of its own until it goes: who does not answer holds up nobody but itself.
class Courier {
 public:
  static constexpr int at_once = 4;
  using Send = std::function<Reply(const job::Delivery&, const std::stop_token&)>;
  /// `first_pause` is between the first two tries of one callback.
  Courier(job::Queue& queue, Send send, std::chrono::milliseconds first_pause);
  ~Courier();

 private:
  void run(const std::stop_token& stop);
  void deliver(const job::Delivery& delivery, const std::stop_token& stop);

  job::Queue& queue_;
  const Send send_;
  const std::chrono::milliseconds first_pause_;
  std::vector<std::jthread> threads_;  // last: the first to go
};

}  // namespace hoodoo::http
