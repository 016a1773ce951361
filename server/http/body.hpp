#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string_view>

#include "server/http/message.hpp"

namespace hoodoo::http {

/// A sender who was waited for so long must have sent this much a second in that time, or is cut
/// off; and so for one who reads an answer.
inline constexpr std::chrono::seconds body_patience{10};
inline constexpr std::size_t least_rate = 4096;  // [bytes / s]

/// Of a body that nobody wants any more so much is passed over, and for no longer than
/// `body_patience`: a sender who is still busy with it when the connection closes may not hear why.
inline constexpr std::size_t most_passed_over = 64u << 20;  // [bytes]

/// Bodies and what is answered to them take no more memory than this, all together.
inline constexpr std::size_t most_bodies = 32u << 20;  // [bytes]

/// What one request takes of something that all take of.
class Share {
 public:
  Share(std::atomic<std::size_t>& taken, std::size_t most) : taken_(taken), most_(most) {}
  ~Share() { taken_ -= mine_; }
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

  /// False when there is not so much left.
  bool add(std::size_t amount) {
    mine_ += amount;
    return taken_.fetch_add(amount) + amount <= most_;
  }

 private:
  std::atomic<std::size_t>& taken_;
  const std::size_t most_;
  std::size_t mine_ = 0;
};

/// Calls its argument with piece after piece until that gives false; true when all have come.
using Pieces = std::function<bool(const std::function<bool(std::string_view)>&)>;

/// Passes a body on until it is whole, it comes too slowly, a stop is requested, or `use` gives
/// false or throws; the rest is then passed over, and what it threw thrown again. Time that `use`
/// takes is not the sender's.
Received receive(const Pieces& pieces, const std::stop_token& stop, const UsePiece& use);

}  // namespace hoodoo::http
