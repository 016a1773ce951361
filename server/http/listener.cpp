#include "server/http/listener.hpp"

#include <fmt/core.h>
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "engine/base/error.hpp"
#include "server/http/api.hpp"
#include "server/http/body.hpp"
#include "server/http/entrance.hpp"
#include "server/http/last_words.hpp"
#include "server/http/log.hpp"
#include "server/http/problem.hpp"
#include "server/http/request_stream.hpp"
#include "server/http/tokens.hpp"
#include "server/http/translation.hpp"

namespace hoodoo::http {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t most_method = 16;  // [bytes] of one that is told
constexpr std::size_t most_unshared = 64u
                                      << 10;  // [bytes] of a body whose answer counts for nothing

bool may_have_body(const std::string& method) {
  return method != "GET" && method != "HEAD" && method != "OPTIONS";
}

bool has_body(const httplib::Request& request) {
  return request.has_header("Content-Length") || request.has_header("Transfer-Encoding");
}

bool is_empty(const httplib::Request& request) {
  return !request.has_header("Transfer-Encoding") &&
         (!request.has_header("Content-Length") ||
          request.get_header_value("Content-Length") == "0");
}

bool is_too_long(const httplib::Request& request) {
  return request.get_header_value_u64("Content-Length") > most_body;
}

/// For a body that was not read whole: the library would read on to its end, and then take requests
/// again. A length that is none has it close the connection.
void cut_off(httplib::Request& request) {
  for (const auto* name : {"Content-Length", "Transfer-Encoding", "Connection"}) {
    request.headers.erase(name);
  }
  request.headers.emplace("Content-Length", "none");
  request.headers.emplace("Connection", "close");
}

/// Whether the last answer of this thread said that the connection closes. The library says so of
/// every error, and then reads on.
thread_local bool said_close = false;

/// A server must date its answers (RFC 9110, 6.6.1), and these two have no content to measure.
void finish(const httplib::Request&, httplib::Response& response) {
  if (response.status == 204 || response.status == 304) response.headers.erase("Content-Length");
  if (response.get_header_value("Accept-Ranges") == "none") response.headers.erase("Accept-Ranges");
  response.set_header("Date", date());
  said_close = response.get_header_value("Connection") == "close";
}

/// What is to be told of a request whose head was refused.
Request begun(const RequestStream& stream) {
  const auto line = stream.first_line();
  const auto space = line.find(' ');
  Request request;
  request.peer = stream.peer();
  request.method = line.substr(0, std::min(space, most_method));
  if (space == line.npos) return request;
  const auto rest = line.substr(space + 1);
  request.path = rest.substr(0, std::min(rest.find_first_of("? "), most_path));
  return request;
}

/// An answer that nobody else has given.
Response noted(const Service& service, Request request, Response response,
               Clock::time_point since) {
  if (service.note) service.note(std::move(request), response, since);
  return response;
}

}  // namespace

struct Listener::Server : httplib::Server {
  using HandlerResponse = httplib::Server::HandlerResponse;

  explicit Server(std::size_t most_connections) : entrance(most_connections) {}
  ~Server() override {
    if (svr_sock_ != INVALID_SOCKET) ::close(svr_sock_);
  }
  void answer(const Service& service, const std::stop_token& stop);
  void configure();
  /// Until `stop`.
  void take_connections(const Service& service, const std::stop_token& stop);

  Entrance entrance;

 private:
  void refuse_or_route(const Service& service, const std::stop_token& stop);
  void expect(const Service& service, const std::stop_token& stop);
  void converse(socket_t socket, Entrance::Turn turn, const Service& service);
  void serve_all(RequestStream& stream, socket_t socket, Entrance::Turn turn,
                 const Service& service);

  std::atomic<std::size_t> held_ = 0;  // [bytes] of bodies and their answers
};

namespace {

bool takes_body(const Service& service, const httplib::Request& from) {
  return service.takes_bodies && may_have_body(from.method) && from.path.size() <= most_path &&
         service.takes_bodies(read_head(from));
}

/// A refusal that needs no more than the head.
std::optional<Response> refusal(const Service& service, const httplib::Request& from) {
  const bool streams = takes_body(service, from);
  if (!streams && is_too_long(from)) return problem(413, "The body is over the limit.");
  if (from.has_header("Content-Encoding")) {
    return problem(415, "Send the body without an encoding.");
  }
  if (has_body(from) &&
      is_media_type(from.get_header_value("Content-Type"), "multipart/form-data")) {
    return problem(415, "Send the body by itself, not as a form.");
  }
  if (from.method == "POST" && !has_body(from) && !streams) {
    return problem(411, "Say how long the body is.");
  }
  return std::nullopt;
}

/// What the library refuses by itself answers in the words of the rest.
httplib::Server::HandlerResponse explain(const Service& service, const httplib::Request& request,
                                         httplib::Response& response) {
  using enum httplib::Server::HandlerResponse;
  if (!response.body.empty() || response.content_provider_) return Unhandled;
  if (response.has_header("X-Request-Id")) return Unhandled;  // it is the service's
  const auto* detail = response.status == 413 ? "The body is over the limit."
                                              : "The request could not be understood.";
  write(noted(service, read_head(request), problem(response.status, detail), request.start_time_),
        response);
  return Handled;
}

/// The answer to a request with a body, which takes of `held` while it is in memory.
Response respond(const Service& service, httplib::Request& from, const ReadBody& read,
                 std::atomic<std::size_t>& held) {
  bool is_read = false;  // it comes only once
  const auto pass_over = [&] {
    if (is_read) return;
    // As bytes, whatever they are said to be.
    from.headers.erase("Content-Type");
    from.headers.erase("Content-Encoding");
    read([](std::string_view) { return false; });
  };
  if (auto refused = refusal(service, from)) {
    auto head = read_head(from);
    pass_over();
    return noted(service, std::move(head), std::move(*refused), from.start_time_);
  }
  auto request = read_head(from);
  if (takes_body(service, from)) {
    auto response = service.answer(std::move(request));
    if (response.take) {
      response = response.take([&](const UsePiece& use) {
        is_read = true;
        return read(use);
      });
    }
    pass_over();
    return response;
  }
  const auto share = std::make_shared<Share>(held, most_bodies);
  bool is_room = true;
  const auto received = read([&](std::string_view piece) {
    request.body += piece;
    is_room = share->add(piece.size());
    return is_room && request.body.size() <= most_body;
  });
  if (!is_room) {
    auto refused = problem(503, "Too many large requests are under way.");
    refused.headers.emplace_back("Retry-After", "1");
    return noted(service, std::move(request), std::move(refused), from.start_time_);
  }
  if (received != Received::whole) {
    return noted(service, std::move(request), not_received(received), from.start_time_);
  }
  const bool is_large = request.body.size() > most_unshared;
  auto response = service.answer(std::move(request));
  if (is_large) response.held = share;
  return response;
}

}  // namespace

void Listener::Server::configure() {
  // The default, SO_REUSEPORT, would let a second server take half of the connections in silence.
  set_socket_options(
      [](socket_t socket) { httplib::set_socket_opt(socket, SOL_SOCKET, SO_REUSEADDR, 1); });
  set_tcp_nodelay(true);
  // Lengths are limited below, route by route.
  set_payload_max_length(std::numeric_limits<std::size_t>::max());
  set_keep_alive_max_count(10'000);
  set_post_routing_handler(finish);
}

/// Serves one connection. The library's own way trusts heads more, and loses requests that come in
/// one packet.
void Listener::Server::converse(socket_t socket, Entrance::Turn turn, const Service& service) {
  RequestStream stream(socket);
  const auto stopping = [this] { return svr_sock_ == INVALID_SOCKET; };
  try {
    serve_all(stream, socket, std::move(turn), service);
  } catch (const std::exception& error) {  // of the library, which has its own catch for routes
    log_fault(std::string("a connection was ended: ") + error.what(), "");
  }
  if (stream.is_cut_off()) entrance.note_slow();
  stream.close(stopping());
}

void Listener::Server::serve_all(RequestStream& stream, socket_t socket, Entrance::Turn turn,
                                 const Service& service) {
  const auto stopping = [this] { return svr_sock_ == INVALID_SOCKET; };
  for (std::size_t left = keep_alive_max_count_; left > 0; --left) {
    if (!turn) turn = std::make_shared<WaitingConnections::Turn>(entrance.waiting(), socket);
    const auto next = stream.next(stopping);
    turn.reset();
    if (std::holds_alternative<RequestStream::Over>(next)) break;
    if (const auto* refusal = std::get_if<Refusal>(&next)) {
      stream.write(last_words(
          noted(service, begun(stream), problem(refusal->status, refusal->detail), Clock::now())));
      break;
    }
    bool closed = false;
    const bool well = process_request(stream, stream.peer(), 0, {}, 0, left == 1, closed, nullptr);
    if (!well || closed || said_close) break;
  }
}

void Listener::Server::take_connections(const Service& service, const std::stop_token& stop) {
  const int listening = svr_sock_;
  {
    // The library looks at its socket to see whether it is to end.
    const std::stop_callback end(stop, [this, listening] {
      svr_sock_ = INVALID_SOCKET;
      ::shutdown(listening, SHUT_RDWR);
    });
    entrance.run(
        listening,
        [this, &service](int socket, Entrance::Turn first) {
          converse(socket, std::move(first), service);
        },
        [] { return last_words(too_many()); }, stop);
  }
  svr_sock_ = INVALID_SOCKET;
  ::close(listening);
}

void Listener::Server::expect(const Service& service, const std::stop_token& stop) {
  set_expect_100_continue_handler(
      [&service, stop](const httplib::Request& from, httplib::Response& to) {
        auto early = refusal(service, from);
        if (early) {
          early = noted(service, read_head(from), std::move(*early), from.start_time_);
        } else if (takes_body(service, from)) {
          early = service.answer(read_head(from));
          if (early->take) early.reset();  // asked again when the body comes
        }
        if (!early) return 100;
        write(std::move(*early), to, stop);
        // Of these answers the library leaves the length to the end of the connection.
        if (!to.body.empty()) to.set_header("Content-Length", std::to_string(to.body.size()));
        return to.status;
      });
}

void Listener::Server::refuse_or_route(const Service& service, const std::stop_token& stop) {
  // Called first for every request. One that may have a body goes on to the routes below.
  set_pre_routing_handler([&service, stop](const httplib::Request& from, httplib::Response& to) {
    auto& request = const_cast<httplib::Request&>(from);
    // Else the library waits for the body of a DELETE that has none, and takes what follows on the
    // connection for it.
    if (is_empty(from)) request.body_consumed_ = true;
    if (has_body(from) && may_have_body(from.method) && from.path.size() <= most_path) {
      return HandlerResponse::Unhandled;
    }
    auto early = refusal(service, from);
    write(early ? noted(service, read_head(from), std::move(*early), from.start_time_)
                : service.answer(read_head(from)),
          to, stop);
    // The library would read it, however slowly it comes.
    if (!is_empty(from)) cut_off(request);
    return HandlerResponse::Handled;
  });
}

void Listener::Server::answer(const Service& service, const std::stop_token& stop) {
  expect(service, stop);
  set_error_handler([&service](const httplib::Request& from, httplib::Response& to) {
    return explain(service, from, to);
  });
  set_exception_handler([&service](const httplib::Request& from, httplib::Response& to,
                                   const std::exception_ptr&) {
    write(noted(service, read_head(from), problem(500, "internal error"), from.start_time_), to);
  });
  refuse_or_route(service, stop);
  const auto with_body = [this, &service, stop](const httplib::Request& from, httplib::Response& to,
                                                const httplib::ContentReader& read) {
    const Pieces pieces = [&read](const std::function<bool(std::string_view)>& use) {
      return read([&use](const char* data, std::size_t length) {
        return use(std::string_view(data, length));
      });
    };
    auto& request = const_cast<httplib::Request&>(from);
    const auto body = [&](const UsePiece& use) { return receive(pieces, stop, use); };
    write(respond(service, request, body, held_), to, stop);
    if (!request.body_consumed_) cut_off(request);
  };
  Post(".*", with_body).Put(".*", with_body).Patch(".*", with_body).Delete(".*", with_body);
}

Listener::Listener(const std::string& host, int port, std::size_t most_connections)
    : server_(std::make_unique<Server>(most_connections)) {
  server_->configure();
  port_ = port == 0 ? server_->bind_to_any_port(host) : port;
  if (port_ < 0 || (port != 0 && !server_->bind_to_port(host, port))) {
    throw Error(Fault::io, fmt::format("{}:{}", host, port),
                "cannot be listened on: it is no address of this machine, or is taken");
  }
}

Listener::~Listener() = default;

ConnectionCounts Listener::connections() const { return server_->entrance.counts(); }

void Listener::run(const Service& service, const std::stop_token& stop) {
  server_->answer(service, stop);
  server_->take_connections(service, stop);
}

}  // namespace hoodoo::http
