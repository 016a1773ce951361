#include "server/http/entrance.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/base/error.hpp"
#include "server/http/log.hpp"

namespace hoodoo::http {
namespace {

using namespace std::chrono_literals;

constexpr auto patience_with_dropped = 1s;  // until its thread is free
constexpr int patience_with_refused = 10;   // [ms]
constexpr auto until_descriptors_end = 50ms;
constexpr auto between_complaints = 10s;

int open_spare() { return ::open("/dev/null", O_RDONLY | O_CLOEXEC); }

int accept_one(int listening) { return ::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC); }

/// Waits for a connection, or for the end of the socket.
void wait_for(int listening) {
  pollfd one{listening, POLLIN, 0};
  ::poll(&one, 1, -1);
}

bool is_short_of_descriptors(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

/// The listening socket itself is no more. What else accept says is of one connection: its errors
/// are given in advance.
bool is_final(int error) {
  return error == EBADF || error == EINVAL || error == ENOTSOCK || error == EFAULT;
}

}  // namespace

Entrance::Entrance(std::size_t most) : spare_(open_spare()), threads_(most) {}

Entrance::~Entrance() {
  if (spare_ >= 0) ::close(spare_);
}

ConnectionCounts Entrance::counts() const { return {open_, accepted_, dropped_, slow_, refused_}; }

bool Entrance::make_room() {
  if (!waiting_.end_oldest()) return false;
  ++dropped_;
  return true;
}

bool Entrance::place(int socket, const Serve& serve) {
  const auto begins = [&] {
    // From now on, not from when its thread has come to it: else a crowd could not make way.
    auto first = std::make_shared<WaitingConnections::Turn>(waiting_, socket);
    return threads_.run([this, socket, &serve, first = std::move(first)]() mutable {
      serve(socket, std::move(first));
      --open_;
    });
  };
  ++open_;
  while (!begins()) {
    if (!make_room()) {
      --open_;
      return false;
    }
    threads_.wait_for_free(patience_with_dropped);
  }
  return true;
}

/// So that a client who has just sent its request can read why: what is closed while bytes are
/// unread is reset. Others wait to be taken meanwhile, so not for long.
void Entrance::refuse(int socket, const Refusal& refusal) {
  ++refused_;
  const auto words = refusal();
  ::send(socket, words.data(), words.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  ::shutdown(socket, SHUT_WR);
  pollfd one{socket, POLLIN, 0};
  std::array<char, 4096> sent;
  if (::poll(&one, 1, patience_with_refused) > 0) {
    ::recv(socket, sent.data(), sent.size(), MSG_DONTWAIT);
  }
  ::close(socket);
}

/// A connection cannot be taken for want of a descriptor: one that waits gives up its own, or else
/// the spare one serves to refuse.
void Entrance::find_descriptor(int listening, const Refusal& refusal) {
  const auto open = open_.load();
  if (make_room()) {
    for (auto left = 20; left > 0 && open_ >= open; --left) std::this_thread::sleep_for(1ms);
    return;
  }
  if (spare_ >= 0) {
    ::close(spare_);
    const int socket = accept_one(listening);
    if (socket >= 0) ++accepted_, refuse(socket, refusal);
  }
  spare_ = open_spare();
  if (spare_ < 0) std::this_thread::sleep_for(until_descriptors_end);
}

void Entrance::run(int listening, const Serve& serve, const Refusal& refusal,
                   const std::stop_token& stop) {
  ::fcntl(listening, F_SETFL, ::fcntl(listening, F_GETFL) | O_NONBLOCK);
  auto complain_from = std::chrono::steady_clock::now();
  int error = 0;
  while (!stop.stop_requested()) {
    wait_for(listening);
    const int socket = accept_one(listening);
    if (socket >= 0) {
      ++accepted_;
      const int yes = 1;
      ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      if (!place(socket, serve)) refuse(socket, refusal);
      continue;
    }
    error = errno;
    if (is_final(error)) break;
    if (!is_short_of_descriptors(error)) continue;
    if (std::chrono::steady_clock::now() >= complain_from) {
      complain_from = std::chrono::steady_clock::now() + between_complaints;
      log_fault(
          fmt::format("connections cannot be taken: {}", std::system_category().message(error)),
          "");
    }
    find_descriptor(listening, refusal);
  }
  threads_.finish();
  if (!stop.stop_requested()) {
    throw Error(Fault::io, "",
                "connections can no longer be accepted: " + std::system_category().message(error));
  }
}

}  // namespace hoodoo::http
