#include "server/http/listener.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <map>
#include <thread>

#include "engine/base/error.hpp"
#include "server/http/api.hpp"

using namespace hoodoo;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using http::Listener;
using http::Request;
using http::Response;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

namespace {

/// A connection to the server under test.
class Connection {
 public:
  Connection() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {}
  explicit Connection(int port) : Connection() { open(port); }
  void open(int port) const {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      ::shutdown(socket_, SHUT_RDWR);
    }
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Before it opens: bytes that the system holds for it.
  void hold(int bytes) const { ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes); }
  void send(const std::string& text) const {
    ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  void send_no_more() const { ::shutdown(socket_, SHUT_WR); }
  /// What arrives next; empty when the server has closed.
  std::string next(std::size_t most = 4096) const {
    std::string piece(most, ' ');
    const auto got = ::recv(socket_, piece.data(), piece.size(), 0);
    piece.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return piece;
  }

 private:
  int socket_;
};

/// Everything the server answers to `text`.
std::string converse(int port, const std::string& text) {
  const Connection connection(port);
  connection.send(text);
  connection.send_no_more();
  std::string answer;
  for (std::string piece; !(piece = connection.next()).empty();) answer += piece;
  return answer;
}

std::string request(const std::string& line, const std::string& headers = "",
                    const std::string& body = "") {
  return line + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + headers + "\r\n" + body;
}

/// Tells what it was asked.
Response echo(const Request& request) {
  if (request.path == "/throw") throw std::runtime_error("secret");
  Response response;
  if (request.path == "/taken") {
    if (request.header("refuse") == "yes") {
      response.status = 422;
      return response;
    }
    response.take = [](const http::ReadBody& read) {
      std::size_t came = 0;
      const auto how = read([&came](std::string_view piece) {
        came += piece.size();
        return true;
      });
      Response taken;
      taken.type = "text/plain";
      taken.body = how == http::Received::whole ? std::to_string(came) + " came" : "broken";
      return taken;
    };
    return response;
  }
  if (request.path == "/large") {
    response.type = "text/plain";
    response.body.assign(32u << 20, 'x');
    return response;
  }
  if (request.path == "/quiet") {
    response.type = "text/event-stream";
    response.more = [until = Clock::now() + 13s,
                     rest = std::deque<std::string>{"first", "last"}]() mutable {
      std::optional<std::string> piece = "";
      if (rest.empty()) return std::optional<std::string>();
      if (rest.size() == 1 && Clock::now() < until) return piece;
      piece = rest.front();
      rest.pop_front();
      return piece;
    };
    return response;
  }
  if (request.path == "/breaks") {
    response.type = "text/event-stream";
    response.more = [said = false]() mutable -> std::optional<std::string> {
      if (said) throw std::runtime_error("secret");
      said = true;
      return "first";
    };
    return response;
  }
  if (request.path == "/file") response.headers = {{"Accept-Ranges", "bytes"}};
  if (request.path == "/none") {
    response.status = 304;
    return response;
  }
  response.type = "text/plain";
  response.body = request.method + " " + request.path + " " + std::string(request.header("range")) +
                  " " + std::to_string(request.body.size());
  return response;
}

class Listening : public testing::Test {
 protected:
  Listening() : thread([this](const std::stop_token& stop) { listener.run(service, stop); }) {}

  std::string send(const std::string& text) const { return converse(listener.port(), text); }

  const http::Service service{echo, [](const Request& head) { return head.path == "/taken"; },
                              [](const Request& refused, Response& answer, Clock::time_point) {
                                answer.headers.emplace_back(
                                    "X-Noted", refused.method + refused.path + refused.peer);
                              }};
  Listener listener{"127.0.0.1", 0};
  std::jthread thread;
};

TEST_F(Listening, AnswersOverASocket) {
  const auto answer = send(request("GET /a%20b?c=d"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("\r\nDate: "));
  EXPECT_THAT(answer, HasSubstr("GET /a b  0"));
}
TEST_F(Listening, LeavesRangesToTheHandler) {
  const auto answer = send(request("GET /", "Range: bytes=0-0\r\n"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("GET / bytes=0-0 0"));
  EXPECT_THAT(send(request("GET /", "Range: bytes=abc\r\n")), HasSubstr("GET / bytes=abc 0"));
  const auto posted = send(request("POST /", "Range: bytes=9-1\r\nContent-Length: 1\r\n", "x"));
  EXPECT_THAT(posted, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("POST /  1")));
}
TEST_F(Listening, GivesBodiesWhole) {
  EXPECT_THAT(send(request("POST /", "Content-Length: 3\r\n", "abc")), HasSubstr("POST /  3"));
  EXPECT_THAT(send(request("POST /", "Transfer-Encoding: chunked\r\n", "2\r\nab\r\n0\r\n\r\n")),
              HasSubstr("POST /  2"));
  EXPECT_THAT(send(request("DELETE /")), HasSubstr("DELETE /  0"));
}
TEST_F(Listening, TakesNothingForTheBodyOfADeleteThatHasNone) {
  const Connection connection(listener.port());
  connection.send("DELETE /a HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_THAT(connection.next(), HasSubstr("DELETE /a  0"));
  connection.send(request("GET /b"));
  EXPECT_THAT(connection.next(), HasSubstr("GET /b"));
}
TEST_F(Listening, RefusesABodyOverTheLimit) {
  const auto length = std::to_string(http::most_body + 1);
  EXPECT_THAT(send(request("POST /", "Content-Length: " + length + "\r\n", "x")),
              StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(send(request("POST /", "Expect: 100-continue\r\nContent-Length: " + length + "\r\n")),
              StartsWith("HTTP/1.1 413"));
}
TEST_F(Listening, RefusesABodyWithoutLengthOrWithAnEncoding) {
  EXPECT_THAT(send(request("POST /")), StartsWith("HTTP/1.1 411"));
  EXPECT_THAT(send(request("POST /", "Content-Encoding: gzip\r\nContent-Length: 1\r\n", "x")),
              StartsWith("HTTP/1.1 415"));
}
TEST_F(Listening, GivesABodyPieceByPieceToWhoTakesIt) {
  const std::string body(http::most_body + 1, 'x');
  const auto length = "Content-Length: " + std::to_string(body.size()) + "\r\n";
  EXPECT_THAT(send(request("PUT /taken", length, body)), HasSubstr("4194305 came"));
  EXPECT_THAT(send(request("PUT /taken", length, "abc")), HasSubstr("broken"));
  EXPECT_THAT(send(request("PUT /taken", "Content-Length: 0\r\n")), HasSubstr("0 came"));
}
TEST_F(Listening, SaysWithoutTheBodyWhatItCan) {
  const std::string expects = "Expect: 100-continue\r\nContent-Length: 3\r\n";
  EXPECT_THAT(send(request("PUT /taken", expects, "abc")), StartsWith("HTTP/1.1 100"));
  EXPECT_THAT(send(request("PUT /taken", expects + "Refuse: yes\r\n")),
              AllOf(StartsWith("HTTP/1.1 422"), HasSubstr("Content-Length: ")));
}
TEST_F(Listening, TakesNothingOfAnUnreadBodyForARequest) {
  const std::string inner = "GET /b HTTP/1.1\r\nHost: a\r\n\r\n";
  const auto length = "Content-Length: " + std::to_string(inner.size()) + "\r\n";
  const auto head = "PUT /taken HTTP/1.1\r\nHost: a\r\n";
  for (const std::string& more :
       {length + "Refuse: yes\r\n", length + "Content-Encoding: gzip\r\n"}) {
    const auto answer = send(head + more + "\r\n" + inner);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 4"));
    EXPECT_THAT(answer, Not(HasSubstr("GET /b")));
  }
}
TEST_F(Listening, RefusesForms) {
  const auto form = "Content-Type: multipart/form-data; boundary=x\r\nContent-Length: 3\r\n";
  EXPECT_THAT(send(request("POST /", form, "abc")), StartsWith("HTTP/1.1 415"));
  EXPECT_THAT(send(request("PUT /taken", form, "abc")), StartsWith("HTTP/1.1 415"));
  const auto shouted = "Content-Type: Multipart/Form-Data; boundary=x\r\nContent-Length: 3\r\n";
  EXPECT_THAT(send(request("POST /", shouted, "abc")), StartsWith("HTTP/1.1 415"));
}
TEST_F(Listening, RefusesWhatIsNoRequest) {
  EXPECT_THAT(send("nonsense\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  const auto smuggled =
      send(request("POST /", "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n", "0\r\n\r\n"));
  EXPECT_THAT(smuggled, StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(smuggled, HasSubstr("application/problem+json"));
}
TEST_F(Listening, CutsOffWhoReadsTooSlowlyAndNobodyElse) {
  const auto begun = Clock::now();
  const auto reads = [&](int held, std::size_t most, Clock::duration pause, Clock::duration end) {
    const Connection connection;
    connection.hold(held);
    connection.open(listener.port());
    connection.send(request("GET /large"));
    bool open = true;
    while (open && Clock::now() < begun + end) {
      std::this_thread::sleep_for(pause);
      open = !connection.next(most).empty();
    }
    return open;
  };
  std::string quiet;
  bool steady = false;
  {
    const std::jthread says_little([&] {
      const Connection connection(listener.port());
      connection.send(request("GET /quiet"));
      for (std::string piece; !(piece = connection.next()).empty();) quiet += piece;
    });
    const std::jthread reads_on([&] { steady = reads(65536, 32768, 250ms, 16s); });
    EXPECT_FALSE(reads(4096, 4096, 2s, 40s)) << "2 KiB/s for 40 s";
  }
  EXPECT_TRUE(steady) << "at most 128 KiB/s";
  EXPECT_THAT(quiet, AllOf(HasSubstr("first"), HasSubstr("last")));
  EXPECT_EQ(listener.connections().slow, 1U);
}
TEST_F(Listening, TellsOfWhatItRefusesByItself) {
  EXPECT_THAT(send(request("GET /a")), Not(HasSubstr("X-Noted")));
  for (const auto& [head, noted] : std::map<std::string, std::string>{
           {request("TRACE /a?b"), "TRACE/a127.0.0.1"},
           {"nonsense\r\n\r\n", "nonsense127.0.0.1"},
           {request("POST /a"), "POST/a127.0.0.1"},
           {request("POST /a", "Content-Length: 3\r\n", "x"), "POST/a127.0.0.1"},
           {request("PUT /taken", "Expect: 100-continue\r\nContent-Encoding: gzip\r\n"),
            "PUT/taken127.0.0.1"},
           {request("GET /a", "Accept: a/b;q=high\r\n"), "GET/a127.0.0.1"},
           {request("GET /throw"), "GET/throw127.0.0.1"}}) {
    EXPECT_THAT(send(head), HasSubstr("X-Noted: " + noted + "\r\n")) << head;
  }
}
TEST_F(Listening, SaysNothingOfWhatWentWrongInside) {
  const auto answer = send(request("GET /throw"));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 500"));
  EXPECT_THAT(answer, Not(HasSubstr("secret")));
}
TEST_F(Listening, EndsAStreamThatGoesWrongAndNothingElse) {
  const Connection follower(listener.port());
  follower.send(request("GET /breaks"));
  std::string answer;
  for (std::string piece; !(piece = follower.next()).empty();) answer += piece;
  EXPECT_THAT(answer, HasSubstr("first"));
  EXPECT_THAT(answer, Not(HasSubstr("secret")));
  EXPECT_THAT(answer, Not(HasSubstr("0\r\n\r\n"))) << "it did not end well";
  EXPECT_THAT(send(request("GET /after")), StartsWith("HTTP/1.1 200"));
}
TEST_F(Listening, SaysThatRangesAreServedOnlyWhereTheyAre) {
  EXPECT_THAT(send(request("HEAD /")), Not(HasSubstr("Accept-Ranges")));
  EXPECT_THAT(send(request("GET /")), Not(HasSubstr("Accept-Ranges")));
  EXPECT_THAT(send(request("HEAD /file")), HasSubstr("Accept-Ranges: bytes"));
}
TEST_F(Listening, MeasuresNoContentWhereThereIsNone) {
  EXPECT_THAT(send(request("GET /none")), Not(HasSubstr("Content-Length")));
}
TEST_F(Listening, SharesItsAddressWithNobody) {
  EXPECT_THROW(Listener("127.0.0.1", listener.port()), Error);
}
TEST_F(Listening, EndsWhenAsked) {
  const int port = listener.port();
  EXPECT_NE(send(request("GET /")), "");
  thread.request_stop();
  thread.join();
  EXPECT_EQ(converse(port, request("GET /")), "");
}
TEST(Listener, MayBeStoppedBeforeItRuns) {
  Listener listener("127.0.0.1", 0);
  std::stop_source stop;
  stop.request_stop();
  listener.run({echo, {}, {}}, stop.get_token());
}
TEST(Listener, RefusesAnAddressThatIsNotItsOwn) { EXPECT_THROW(Listener("192.0.2.1", 0), Error); }

}  // namespace
