#include "server/http/outgoing.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <string>
#include <string_view>
#include <thread>

using namespace hoodoo;

namespace {

constexpr const char* changing = "changing.invalid";
std::atomic<int> times_asked = 0;

/// Says 204 to whoever comes first to a port of the loopback address.
class Host {
 public:
  Host() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(socket_, any, size), 0);
    EXPECT_EQ(::listen(socket_, 1), 0);
    EXPECT_EQ(::getsockname(socket_, any, &size), 0);
    port_ = ntohs(address.sin_port);
    answering_ = std::thread([this] { answer(); });
  }
  ~Host() {
    ::shutdown(socket_, SHUT_RDWR);  // ends a wait for somebody who never came
    answering_.join();
    ::close(socket_);
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  int port() const { return port_; }

 private:
  void answer() const {
    const int guest = ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (guest < 0) return;
    std::string head(1000, ' ');
    constexpr std::string_view answer = "HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n";
    if (::recv(guest, head.data(), head.size(), 0) > 0) {
      EXPECT_EQ(::send(guest, answer.data(), answer.size(), MSG_NOSIGNAL), std::ssize(answer));
    }
    ::close(guest);
  }

  int socket_, port_ = 0;
  std::thread answering_;
};

}  // namespace

/// Stands before the one of the C library for all of this program, libcurl too. The name `changing`
/// leads to this machine the first time, and nowhere later, as an unfriendly server of names would
/// have it.
extern "C" int getaddrinfo(const char* name, const char* service, const addrinfo* hints,
                           addrinfo** found) {
  using Function = int(const char*, const char*, const addrinfo*, addrinfo**);
  static const auto real = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, "getaddrinfo"));
  if (name == nullptr || std::strcmp(name, changing) != 0) {
    return real(name, service, hints, found);
  }
  return ++times_asked == 1 ? real("127.0.0.1", service, hints, found) : EAI_NONAME;
}

TEST(Outgoing, GoesWhereItsNameLedWhenThatWasLookedAt) {
  const Host host;
  const auto at = [&](const std::string& name) { return name + ":" + std::to_string(host.port()); };
  const http::AllowList allowed({at(changing), at("127.0.0.1")}, "--callback-allow");
  http::Outgoing request("http://" + at(changing) + "/news", allowed, [] { return false; });
  EXPECT_FALSE(request.is_refused()) << request.refusal().why;
  std::string why;
  EXPECT_EQ(request.perform(why), 204) << why;
  EXPECT_EQ(times_asked, 1) << "what it leads to later may be no public address";
}
