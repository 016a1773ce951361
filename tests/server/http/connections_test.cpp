#include "server/http/connections.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <latch>
#include <thread>

namespace hoodoo::http {
namespace {

using namespace std::chrono_literals;

TEST(ConnectionThreads, ServeAllAtOnce) {
  constexpr int count = 300;
  ConnectionThreads threads(count);
  std::latch all(count);
  for (int i = 0; i < count; ++i) {
    // None ends before the last has begun.
    ASSERT_TRUE(threads.run([&] { all.arrive_and_wait(); }));
  }
  threads.finish();
  EXPECT_TRUE(all.try_wait());
}

TEST(ConnectionThreads, AreUsedAgainWithoutOneWaitingForAnother) {
  ConnectionThreads threads(64);
  std::atomic<int> served = 0;
  for (int round = 0; round < 50; ++round) {
    std::latch together(32), ended(32);
    for (int i = 0; i < 32; ++i) {
      ASSERT_TRUE(threads.run([&] {
        together.arrive_and_wait();
        ++served;
        ended.count_down();
      }));
    }
    ended.wait();
  }
  EXPECT_EQ(served, 50 * 32);
  threads.finish();
}

TEST(ConnectionThreads, RefuseMoreThanTheMost) {
  ConnectionThreads threads(2);
  std::latch held(1);
  EXPECT_TRUE(threads.run([&] { held.wait(); }));
  EXPECT_TRUE(threads.run([&] { held.wait(); }));
  EXPECT_FALSE(threads.run([] {}));
  held.count_down();
  threads.finish();
  EXPECT_FALSE(threads.run([] {})) << "it has finished";
}

TEST(WaitingConnections, EndInTheOrderInWhichTheyBeganToWait) {
  std::array<std::array<int, 2>, 3> pairs;
  for (auto& pair : pairs) ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()), 0);
  const auto has_ended = [&](std::size_t i) {
    char byte = 0;
    return ::recv(pairs.at(i)[1], &byte, 1, MSG_DONTWAIT) == 0;
  };
  WaitingConnections waiting;
  {
    const WaitingConnections::Turn first(waiting, pairs[0][0]);
    const WaitingConnections::Turn second(waiting, pairs[1][0]);
    { const WaitingConnections::Turn busy_now(waiting, pairs[2][0]); }
    EXPECT_TRUE(waiting.end_oldest());
    EXPECT_TRUE(has_ended(0));
    EXPECT_FALSE(has_ended(1));
    EXPECT_TRUE(waiting.end_oldest());
    EXPECT_TRUE(has_ended(1));
    EXPECT_FALSE(waiting.end_oldest()) << "none is left";
  }
  EXPECT_FALSE(has_ended(2));
  for (const auto& pair : pairs) ::close(pair[0]), ::close(pair[1]);
}

}  // namespace
}  // namespace hoodoo::http
