#include "server/http/entrance.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "tests/server/http/few_descriptors.hpp"

using namespace hoodoo;
using namespace std::chrono_literals;
using http::Entrance;

namespace {

/// A client. Its descriptor is taken before it connects.
class Client {
 public:
  Client() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval patience{20, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void open(const sockaddr_in& address) const {
    ASSERT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  void send(char what) const { ::send(socket_, &what, 1, MSG_NOSIGNAL); }
  /// What comes until the other side closes, or as much as `most`.
  std::string read(std::size_t most = 100) const {
    std::string all;
    for (char byte = 0; all.size() < most && ::recv(socket_, &byte, 1, 0) == 1;) all += byte;
    return all;
  }

 private:
  int socket_;
};

/// Says "+" to a client; waits for what it says as for a request, and serves 'w' until the test
/// lets it go.
class Entering : public testing::Test {
 protected:
  Entering() : listening_(::socket(AF_INET, SOCK_STREAM, 0)) {
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(listening_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(listening_, 16), 0);
    ::getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      const std::stop_callback end(stop, [this] { ::shutdown(listening_, SHUT_RDWR); });
      entrance.run(
          listening_, [this](int socket, Entrance::Turn first) { serve(socket, std::move(first)); },
          [] { return "full"; }, stop);
    });
  }
  ~Entering() override {
    works_ = false;
    thread_.request_stop();
    while (entrance.waiting().end_oldest()) {
    }
    thread_.join();
    ::close(listening_);
  }

  /// A client whose connection waits, or works.
  void enter(const Client& client, bool works = false) const {
    client.open(address);
    ASSERT_EQ(client.read(1), "+");
    if (!works) return;
    client.send('w');
    ASSERT_EQ(client.read(1), "w");
  }

  sockaddr_in address{};
  Entrance entrance{2};
  std::atomic<std::chrono::milliseconds> until_served = 0ms;  // of a connection with a thread

 private:
  void serve(int socket, Entrance::Turn turn) {
    char said = 0;
    std::this_thread::sleep_for(until_served.load());
    ::send(socket, "+", 1, MSG_NOSIGNAL);
    ::recv(socket, &said, 1, 0);
    turn.reset();
    if (said == 'w') ::send(socket, "w", 1, MSG_NOSIGNAL);
    while (said == 'w' && works_) std::this_thread::sleep_for(10ms);
    ::close(socket);
  }

  const int listening_;
  std::atomic<bool> works_ = true;
  std::jthread thread_;
};

TEST_F(Entering, TheOneGoesThatHasWaitedLongestWhenThereAreTooMany) {
  const Client first, second, third, fourth;
  enter(first);
  enter(second);
  enter(third);
  EXPECT_EQ(first.read(), "") << "it has been closed";
  enter(fourth);
  EXPECT_EQ(second.read(), "");
  const auto counts = entrance.counts();
  EXPECT_EQ(counts.accepted, 4U);
  EXPECT_EQ(counts.dropped, 2U);
  EXPECT_EQ(counts.refused, 0U);
}

TEST_F(Entering, WhoHasJustComeMakesWayToo) {
  until_served = 100ms;
  std::array<Client, 6> crowd;
  for (const auto& one : crowd) one.open(address);
  EXPECT_EQ(crowd.back().read(1), "+");
  const auto counts = entrance.counts();
  EXPECT_EQ(counts.accepted, 6U);
  EXPECT_EQ(counts.dropped, 4U);
  EXPECT_EQ(counts.refused, 0U);
}

TEST_F(Entering, WhoWorksStays) {
  const Client worker, first, second;
  enter(worker, true);
  enter(first);
  enter(second);
  EXPECT_EQ(first.read(), "");
  second.send('w');
  EXPECT_EQ(second.read(1), "w");
  const Client refused;
  refused.open(address);
  EXPECT_EQ(refused.read(), "full");
  const auto counts = entrance.counts();
  EXPECT_EQ(counts.open, 2U);
  EXPECT_EQ(counts.dropped, 1U);
  EXPECT_EQ(counts.refused, 1U);
}

TEST_F(Entering, WithoutDescriptorsOneThatWaitsGivesUpItsOwn) {
  const Client first, second;
  enter(first);
  const NoMoreDescriptors none;
  enter(second);
  EXPECT_EQ(first.read(), "");
  EXPECT_EQ(entrance.counts().dropped, 1U);
}

TEST_F(Entering, WithoutDescriptorsWhoComesIsRefusedWhereNoneWaits) {
  const Client worker, refused, again;
  enter(worker, true);
  const NoMoreDescriptors none;
  for (const auto* client : {&refused, &again}) {
    client->open(address);
    EXPECT_EQ(client->read(), "full");
  }
  EXPECT_EQ(entrance.counts().refused, 2U);
}

}  // namespace
