#pragma once
#include <httplib.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "server/http/head.hpp"

namespace hoodoo::http {

/// One connection as the HTTP library reads it: head after head, each whole and checked, and the
/// bodies between, whose framing is. What comes in one packet with a request stays for the next.
/// A client who takes answers at less than `least_rate` is cut off.
class RequestStream final : public httplib::Stream {
 public:
  explicit RequestStream(socket_t socket);

  /// The connection has ended, or has said nothing for a while.
  struct Over {};
  struct Ready {};
  /// Waits for the next request. When it is ready its head is what `read` gives first. Gives up
  /// when nothing has come and `stopping`.
  std::variant<Over, Ready, Refusal> next(const std::function<bool()>& stopping);
  /// Ends the connection so that whoever is still sending can read the last answer.
  void close(bool at_once);

  /// The address at the other end, as a number.
  const std::string& peer() const { return peer_; }
  /// The beginning of a request that was refused.
  std::string_view first_line() const;
  /// The client read too slowly: nothing more is written.
  bool is_cut_off() const { return cut_off_; }

  bool is_readable() const override;
  bool wait_readable() const override;
  bool wait_writable() const override { return !cut_off_; }  // `write` waits itself
  bool is_peer_alive() const override;
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  using Stream::write;
  socket_t socket() const override { return socket_; }
  time_t duration() const override { return 0; }
  // Nobody asks: see `peer`.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}

 private:
  bool has_bytes() const { return head_at_ < head_.size() || at_ < buffer_.size(); }
  bool wait(short what, std::chrono::milliseconds patience) const;
  bool wait_for_reader();
  ssize_t receive();
  std::optional<Refusal> gather();
  ssize_t read_unwatched(char* to, std::size_t size);
  bool watch(std::string_view bytes, std::chrono::steady_clock::duration waited);

  const socket_t socket_;
  std::string peer_;
  std::string head_;    // as the library is to read it
  std::string buffer_;  // what has come after
  std::size_t head_at_ = 0, at_ = 0;
  std::optional<ChunkWatch> chunks_;
  std::chrono::steady_clock::duration framing_{0};  // waited for since content came last
  std::size_t written_ = 0;                         // [bytes] in all
  std::size_t taken_ = 0;  // [bytes] of them that the client had when it was looked at last
  std::chrono::steady_clock::duration waited_{0};  // for the client since then
  bool cut_off_ = false;
};

}  // namespace hoodoo::http
