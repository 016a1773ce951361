#include "server/http/request_stream.hpp"

#include <linux/sockios.h>
#include <netdb.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "server/http/body.hpp"

namespace hoodoo::http {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto patience_with_silence = 5s;  // between two requests
constexpr auto patience_with_head = 10s;    // from its first byte to its last
constexpr auto patience_with_end = 2s;
constexpr auto between_looks = 250ms;  // at whether the server stops
constexpr std::size_t piece = 16u << 10;
constexpr std::string_view line_end = "\r\n", head_end = "\r\n\r\n";

std::chrono::milliseconds until(Clock::time_point end) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
  return std::max(left, 0ms);
}

std::string peer_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  auto* any = reinterpret_cast<sockaddr*>(&address);
  std::array<char, NI_MAXHOST> text{};
  if (::getpeername(socket, any, &size) != 0) return {};
  if (::getnameinfo(any, size, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) != 0)
    return {};
  const std::string_view name(text.data());
  constexpr std::string_view version_4 = "::ffff:";  // on a socket of both versions
  return std::string(name.substr(name.starts_with(version_4) ? version_4.size() : 0));
}

}  // namespace

RequestStream::RequestStream(socket_t socket) : socket_(socket), peer_(peer_of(socket)) {}

std::string_view RequestStream::first_line() const {
  const std::string_view all(buffer_);
  return all.substr(0, all.find(line_end));
}

bool RequestStream::wait(short what, std::chrono::milliseconds patience) const {
  const auto end = Clock::now() + patience;
  pollfd one{socket_, what, 0};
  for (;;) {
    const int ready = ::poll(&one, 1, static_cast<int>(until(end).count()));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

bool RequestStream::is_readable() const { return has_bytes() || wait(POLLIN, 0ms); }
bool RequestStream::wait_readable() const { return has_bytes() || wait(POLLIN, body_patience); }
bool RequestStream::is_peer_alive() const {
  return !cut_off_ && httplib::detail::is_socket_alive(socket_);
}

/// Adds what has come to the buffer; as recv does it tells how much, and when all has.
ssize_t RequestStream::receive() {
  std::array<char, piece> came;
  ssize_t got = 0;
  do {
    got = ::recv(socket_, came.data(), came.size(), 0);
  } while (got < 0 && errno == EINTR);
  if (got > 0) buffer_.append(came.data(), static_cast<std::size_t>(got));
  return got;
}

/// Has the buffer hold a whole head, unless it never will.
std::optional<Refusal> RequestStream::gather() {
  const auto end = Clock::now() + patience_with_head;
  // RFC 9112, 2.2: one empty line before a request is none of it.
  for (bool may_skip = true;;) {
    if (may_skip && buffer_.starts_with(line_end)) {
      buffer_.erase(0, line_end.size());
      may_skip = false;
    }
    if (buffer_.find(head_end) <= most_head) return std::nullopt;
    if (auto wrong = wrong_so_far(buffer_)) return wrong;
    if (!wait(POLLIN, until(end))) return Refusal{408, "The head came too slowly."};
    if (receive() <= 0) return Refusal{400, "The head did not come whole."};
  }
}

std::variant<RequestStream::Over, RequestStream::Ready, Refusal> RequestStream::next(
    const std::function<bool()>& stopping) {
  buffer_.erase(0, std::exchange(at_, 0));
  for (const auto end = Clock::now() + patience_with_silence; buffer_.empty();) {
    const auto left = until(end);
    if (wait(POLLIN, std::min<std::chrono::milliseconds>(left, between_looks))) {
      if (receive() <= 0) return Over{};
    } else if (left == 0ms || stopping()) {
      return Over{};
    }
  }
  if (auto refused = gather()) return *refused;
  const auto length = buffer_.find(head_end) + head_end.size();
  auto read = read_head(std::string_view(buffer_).substr(0, length));
  if (auto* refused = std::get_if<Refusal>(&read)) return *refused;
  auto& head = std::get<Head>(read);
  head_ = std::move(head.text);
  head_at_ = 0;
  at_ = length;
  chunks_.reset();
  if (head.chunked) chunks_.emplace();
  framing_ = {};
  return Ready{};
}

ssize_t RequestStream::read_unwatched(char* to, std::size_t size) {
  if (at_ == buffer_.size()) {
    buffer_.clear();
    at_ = 0;
    if (!wait(POLLIN, body_patience)) {
      error_ = httplib::Error::Timeout;
      return -1;
    }
    const auto got = receive();
    if (got <= 0) {
      error_ = got == 0 ? httplib::Error::ConnectionClosed : httplib::Error::Read;
      return got;
    }
  }
  const auto length = std::min(size, buffer_.size() - at_);
  std::memcpy(to, buffer_.data() + at_, length);
  at_ += length;
  return static_cast<ssize_t>(length);
}

/// False when the framing of a chunked body is wrong, or dawdles.
bool RequestStream::watch(std::string_view bytes, Clock::duration waited) {
  framing_ = chunks_->in_content() ? Clock::duration{0} : framing_ + waited;
  return framing_ < body_patience && chunks_->see(bytes);
}

ssize_t RequestStream::read(char* to, std::size_t size) {
  if (head_at_ < head_.size()) {
    const auto length = std::min(size, head_.size() - head_at_);
    std::memcpy(to, head_.data() + head_at_, length);
    head_at_ += length;
    return static_cast<ssize_t>(length);
  }
  const auto from = Clock::now();
  const auto got = read_unwatched(to, size);
  if (got <= 0 || !chunks_) return got;
  if (watch({to, static_cast<std::size_t>(got)}, Clock::now() - from)) return got;
  error_ = httplib::Error::Read;
  return -1;
}

/// Waits until something can be written; false when the client takes too little. What counts is
/// what has arrived, not what the system holds for it: of that it takes megabytes, and there is
/// only room again when much of it has gone. Time in which there is nothing to write is not waited.
bool RequestStream::wait_for_reader() {
  constexpr auto least = least_rate * static_cast<std::size_t>(body_patience.count());
  for (;;) {
    const auto from = Clock::now();
    const bool ready = wait(POLLOUT, 1s);
    waited_ += Clock::now() - from;
    if (waited_ >= body_patience) {
      int held = 0;
      ::ioctl(socket_, SIOCOUTQ, &held);
      const auto taken = written_ - static_cast<std::size_t>(held);
      if (taken < taken_ + least) return false;
      taken_ = taken;
      waited_ = {};
    }
    if (ready) return true;
  }
}

ssize_t RequestStream::write(const char* from, std::size_t size) {
  ssize_t sent = -1;
  while (sent < 0) {
    if (cut_off_ || !wait_for_reader()) {
      cut_off_ = true;
      error_ = httplib::Error::Timeout;
      return -1;
    }
    sent = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EINTR && errno != EAGAIN) return sent;
  }
  written_ += static_cast<std::size_t>(sent);
  return sent;
}

void RequestStream::close(bool at_once) {
  if (cut_off_) {
    // What it has not taken would be kept for it.
    const linger none{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    ::close(socket_);
    return;
  }
  ::shutdown(socket_, SHUT_WR);
  // Closed while bytes are unread, it would be reset, and the answer lost on its way.
  const auto end = Clock::now() + (at_once ? 0s : patience_with_end);
  std::array<char, piece> rest;
  for (std::size_t passed = 0; passed < most_passed_over && wait(POLLIN, until(end));) {
    const auto got = ::recv(socket_, rest.data(), rest.size(), 0);
    if (got <= 0) break;
    passed += static_cast<std::size_t>(got);
  }
  ::shutdown(socket_, SHUT_RDWR);
  ::close(socket_);
}

}  // namespace hoodoo::http
