#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace hoodoo {

/// How much JSON is taken from outside.
struct JsonLimits {
  std::size_t bytes = 64u << 20;
  int depth = 64;
  std::size_t values = 10'000'000;
};

/// Parses JSON from outside, refusing before memory is spent: a text longer than, nested deeper
/// than, or holding more values than `limits`; a duplicate key; a number that is not finite.
/// `where` names the text in messages (a file, "request body").
/// Errors: bad_input with line and column, limit.
nlohmann::json parse_json(std::string_view text, const std::string& where,
                          const JsonLimits& limits = {});

/// `key` as a JSON Pointer token: "~" and "/" escaped (RFC 6901).
std::string pointer_token(std::string_view key);

}  // namespace hoodoo
