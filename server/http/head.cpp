#include "server/http/head.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include "server/http/tokens.hpp"

namespace hoodoo::http {
namespace {

constexpr std::string_view line_end = "\r\n";
constexpr std::size_t most_chunk_digits = 8;

bool is_alphanumeric(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// A token of RFC 9110 without "_".
bool is_name(std::string_view text) {
  constexpr std::string_view marks = "!#$%&'*+-.^`|~";
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return is_alphanumeric(c) || marks.find(c) != marks.npos;
  });
}

/// Bytes of any character set, no control characters but the tab.
bool is_value(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == '\t' || (byte >= ' ' && byte != 0x7f);
  });
}

/// The library compares these with case, which tokens have none of.
std::string_view known(std::string_view name, std::string_view value) {
  constexpr std::array<std::array<std::string_view, 2>, 2> tokens{
      {{"connection", "close"}, {"expect", "100-continue"}}};
  for (const auto& [header, token] : tokens) {
    if (same_token(name, header) && same_token(value, token)) return token;
  }
  return value;
}

int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Visible ASCII; what is encoded in the path is no control character.
bool is_target(std::string_view target) {
  const auto visible = [](char c) { return c > ' ' && c <= '~'; };
  if (target.empty() || !std::ranges::all_of(target, visible)) return false;
  const auto path = target.substr(0, target.find('?'));
  for (auto at = path.find('%'); at != path.npos; at = path.find('%', at + 1)) {
    if (at + 2 >= path.size()) return false;
    const int high = hexadecimal(path[at + 1]), low = hexadecimal(path[at + 2]);
    const int byte = 16 * high + low;
    if (high < 0 || low < 0 || byte < ' ' || byte == 0x7f) return false;
  }
  return true;
}

/// "GET /path HTTP/1.1"; `is_new` when it is of HTTP/1.1.
std::optional<Refusal> wrong_with_line(std::string_view line, bool& is_new) {
  if (line.size() > most_line) return Refusal{414, "The request line is too long."};
  const Refusal wrong{400, "The request line is none."};
  const auto first = line.find(' '), last = line.rfind(' ');
  if (first == line.npos || first == last) return wrong;
  const auto method = line.substr(0, first), version = line.substr(last + 1);
  if (!is_name(method) || !is_target(line.substr(first + 1, last - first - 1))) return wrong;
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    if (!version.starts_with("HTTP/")) return wrong;
    return Refusal{505, "This server speaks HTTP/1.1."};
  }
  is_new = version == "HTTP/1.1";
  constexpr std::array<std::string_view, 7> methods{"GET",   "HEAD",   "POST",   "PUT",
                                                    "PATCH", "DELETE", "OPTIONS"};
  if (std::ranges::find(methods, method) == methods.end()) {
    return Refusal{501, "This server has no such method."};
  }
  return std::nullopt;
}

/// Reads the lines of a head.
class Reader {
 public:
  explicit Reader(std::string_view head) : rest_(head) {}

  std::variant<Head, Refusal> read() {
    const auto line = next();
    bool is_new = false;
    if (auto wrong = wrong_with_line(line, is_new)) return *wrong;
    head_.text.append(line).append(line_end);
    for (std::size_t lines = 0; rest_ != line_end; ++lines) {
      if (lines == most_header_lines) return Refusal{431, "There are too many headers."};
      if (auto wrong = take(next())) return *wrong;
    }
    if (is_new && !has_host_) return Refusal{400, "A request has a Host header."};
    if (head_.chunked && (has_length_ || !is_new)) {
      return Refusal{400, "A body comes by its length or in chunks of HTTP/1.1."};
    }
    head_.text += line_end;
    return std::move(head_);
  }

 private:
  std::string_view next() {
    const auto end = rest_.find(line_end);
    const auto line = rest_.substr(0, end);
    rest_.remove_prefix(end + line_end.size());
    return line;
  }

  std::optional<Refusal> take(std::string_view line) {
    const auto colon = line.find(':');
    const auto name = line.substr(0, colon);
    if (colon == line.npos || !is_name(name)) return Refusal{400, "A header has no plain name."};
    const auto value = known(name, trimmed(line.substr(colon + 1)));
    if (!is_value(value)) return Refusal{400, "A header holds control characters."};
    if (same_token(name, "host") && std::exchange(has_host_, true)) {
      return Refusal{400, "There are two hosts."};
    }
    if (same_token(name, "content-length")) {
      if (std::exchange(has_length_, true)) return Refusal{400, "There are two lengths."};
      const auto read = std::from_chars(value.data(), value.data() + value.size(), head_.length);
      const bool digits = value.find_first_not_of("0123456789") == value.npos;
      if (!digits || read.ec != std::errc() || head_.length > INT64_MAX) {
        return Refusal{400, "Content-Length is no number of bytes."};
      }
    }
    if (same_token(name, "transfer-encoding")) {
      if (!same_token(value, "chunked") || std::exchange(head_.chunked, true)) {
        return Refusal{501, "The only transfer coding here is chunked."};
      }
    }
    // Nothing is upgraded to here, and a server may overlook it (RFC 9110, 7.8); the library would
    // not.
    if (same_token(name, "upgrade")) return std::nullopt;
    const auto from = head_.text.size();
    head_.text.append(same_token(name, "range") ? range_within : name).append(": ");
    const bool as_it_is = same_token(name, "location") || same_token(name, "referer");
    for (const char c : value)
      head_.text += c == '%' && !as_it_is ? "%25" : std::string_view(&c, 1);
    head_.text += line_end;
    if (head_.text.size() - from > most_line) return Refusal{431, "A header is too long."};
    return std::nullopt;
  }

  std::string_view rest_;
  Head head_;
  bool has_host_ = false, has_length_ = false;
};

}  // namespace

std::optional<Refusal> wrong_so_far(std::string_view beginning) {
  for (std::size_t i = 0; i < beginning.size(); ++i) {
    const char c = beginning[i];
    const bool alone = (c == '\n' && (i == 0 || beginning[i - 1] != '\r')) ||
                       (c == '\r' && i + 1 < beginning.size() && beginning[i + 1] != '\n');
    if (alone || c == '\0') return Refusal{400, "A line ends in CR LF."};
  }
  if (beginning.find(line_end) > most_line && beginning.size() > most_line + 1) {
    return Refusal{414, "The request line is too long."};
  }
  if (beginning.size() > most_head) return Refusal{431, "The head is too long."};
  return std::nullopt;
}

std::variant<Head, Refusal> read_head(std::string_view head) {
  if (auto wrong = wrong_so_far(head)) return *wrong;
  return Reader(head).read();
}

bool ChunkWatch::see(std::string_view bytes) {
  while (!bytes.empty()) {
    if (state_ == State::content) {
      const auto passed = std::min(left_, bytes.size());
      bytes.remove_prefix(passed);
      left_ -= passed;
      if (left_ == 0) state_ = State::content_cr;
    } else {
      if (!see(bytes.front())) return false;
      bytes.remove_prefix(1);
    }
  }
  return true;
}

bool ChunkWatch::see(char byte) {
  const auto step = [&](char wanted, State next) {
    state_ = next;
    return byte == wanted;
  };
  switch (state_) {
    case State::size:
      if (const int digit = hexadecimal(byte); digit >= 0) {
        left_ = 16 * left_ + static_cast<std::size_t>(digit);
        return ++digits_ <= most_chunk_digits;
      }
      state_ = State::size_end;
      return byte == '\r' && digits_ > 0;
    case State::size_end:
      digits_ = 0;
      return step('\n', left_ == 0 ? State::last_cr : State::content);
    case State::content_cr:
      return step('\r', State::content_lf);
    case State::content_lf:
      return step('\n', State::size);
    case State::last_cr:
      return step('\r', State::last_lf);
    case State::last_lf:
      return step('\n', State::ended);
    case State::content:
    case State::ended:
      break;
  }
  return false;
}

}  // namespace hoodoo::http
