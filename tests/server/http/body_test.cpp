#include "server/http/body.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>
#include <vector>

using namespace hoodoo::http;

namespace {

/// So many pieces of so many bytes, then the end of the body or of the connection.
struct Sender {
  std::size_t pieces = 0, size = 0;
  bool ends_well = true;
  mutable std::size_t taken = 0;

  bool operator()(const std::function<bool(std::string_view)>& use) const {
    const std::string piece(size, 'x');
    for (std::size_t i = 0; i < pieces; ++i) {
      ++taken;
      if (!use(piece)) return false;
    }
    return ends_well;
  }
};
Received receive_all(const Sender& sender, const UsePiece& use, const std::stop_token& stop = {}) {
  return receive([&sender](const auto& take) { return sender(take); }, stop, use);
}
const UsePiece wanted = [](std::string_view) { return true; };
const UsePiece unwanted = [](std::string_view) { return false; };

TEST(Receive, TellsAWholeBodyFromABrokenOne) {
  EXPECT_EQ(receive_all({3, 10}, wanted), Received::whole);
  EXPECT_EQ(receive_all({0, 0}, wanted), Received::whole);
  EXPECT_EQ(receive_all({3, 10, false}, wanted), Received::broken);
}
TEST(Receive, PassesOverWhatIsNotWantedUpToALimit) {
  const Sender some{4, 1 << 20};
  EXPECT_EQ(receive_all(some, unwanted), Received::refused);
  EXPECT_EQ(some.taken, 4);
  const Sender much{1000, 1 << 20};
  EXPECT_EQ(receive_all(much, unwanted), Received::refused);
  EXPECT_LE(much.taken, (most_passed_over >> 20) + 2);
}
TEST(Receive, PassesOverWhatIsNotWantedForATimeOnly) {
  int pieces = 0;
  const auto trickle = [&pieces](const auto& take) {
    const std::string piece(2 * least_rate, 'x');
    while (take(piece)) ++pieces, std::this_thread::sleep_for(std::chrono::seconds(1));
    return false;
  };
  EXPECT_EQ(receive(trickle, {}, unwanted), Received::refused);
  EXPECT_LE(pieces, body_patience.count() + 1);
}
TEST(Receive, ThrowsWhatItsUserThrewAfterTheRestHasCome) {
  const Sender sender{4, 10};
  EXPECT_THROW(
      receive_all(sender, [](std::string_view) -> bool { throw std::runtime_error("full"); }),
      std::runtime_error);
  EXPECT_EQ(sender.taken, 4);
}
TEST(Receive, EndsWhenTheServerStops) {
  std::stop_source stop;
  stop.request_stop();
  const Sender sender{1000, 10};
  EXPECT_EQ(receive_all(sender, wanted, stop.get_token()), Received::stopped);
  EXPECT_EQ(sender.taken, 1);
}
TEST(Receive, CutsOffWhoDawdlesButNotWhomItKeepsWaiting) {
  const auto nap = [] { std::this_thread::sleep_for(body_patience / 2 + std::chrono::seconds(1)); };
  const auto body = [&](bool sender_naps) {
    return receive(
        [&](const auto& take) {
          for (int i = 0; i < 4; ++i) {
            if (sender_naps) nap();
            if (!take("x")) return false;
            if (sender_naps && i == 2) return true;
          }
          return true;
        },
        {},
        [&, i = 0](std::string_view) mutable {
          if (!sender_naps && ++i < 3) nap();
          return true;
        });
  };
  EXPECT_EQ(body(true), Received::slow);
  EXPECT_EQ(body(false), Received::whole);
}

}  // namespace
