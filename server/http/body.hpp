#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string_view>

#include "server/http/message.hpp"

namespace hoodoo::http {

/// A sender who was waited for so long must have sent this much a second in that time, or is cut
/// off.
inline constexpr std::chrono::seconds body_patience{10};
inline constexpr std::size_t least_rate = 4096;  // [bytes / s]

/// Calls its argument with piece after piece until that gives false; true when all have come.
using Pieces = std::function<bool(const std::function<bool(std::string_view)>&)>;

/// Passes a body on until it is whole, `use` wants no more, it comes too slowly, or a stop is
/// requested. Time that `use` takes is not the sender's.
Received receive(const Pieces& pieces, const std::stop_token& stop, const UsePiece& use);

}  // namespace hoodoo::http
