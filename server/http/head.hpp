#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// Which heads of requests are taken at all, before any library reads them.
namespace hoodoo::http {

inline constexpr std::size_t most_head = 16u << 10;  // [bytes]
inline constexpr std::size_t most_line = 8u << 10;   // [bytes] as the library is to read it
inline constexpr std::size_t most_header_lines = 64;

/// The header Range on its way through the library, which refuses whole requests for one that is
/// none. No client's header has such a name.
inline constexpr std::string_view range_within = "range_within";

/// Why no request is read from a connection any more.
struct Refusal {
  int status = 400;
  const char* detail = "";
};

/// A head that may be read, in the form in which the library reads it as it was meant: it decodes
/// "%41" in the values of headers, which nobody else does.
struct Head {
  std::string text;
  bool chunked = false;    // how the body comes
  std::size_t length = 0;  // [bytes] of a body that does not
};

/// What is wrong with the beginning of a head whatever may follow; nothing, if that is open.
/// RFC 9112, 2.2: a line ends in CR LF, and neither stands alone. To be asked as bytes come.
std::optional<Refusal> wrong_so_far(std::string_view beginning);

/// Takes a head, with the empty line that ends it.
///
/// Two readings of one request let a second one be smuggled past whoever has read the first
/// otherwise, so all that RFC 9112 leaves open is refused: two lengths, a length beside chunks, a
/// length that is none, codings other than chunked, folded lines, spaces before a colon, two hosts.
/// So are names with "_", which gateways take for others, and paths with control characters.
std::variant<Head, Refusal> read_head(std::string_view head);

/// Watches a chunked body go by, and tells when its framing is not what RFC 9112 says. Extensions
/// and trailers, which nobody uses, are refused.
class ChunkWatch {
 public:
  /// False from the first byte on that is wrong.
  bool see(std::string_view bytes);
  /// True while content comes, and not its framing.
  bool in_content() const { return state_ == State::content; }
  bool ended() const { return state_ == State::ended; }

 private:
  enum class State { size, size_end, content, content_cr, content_lf, last_cr, last_lf, ended };
  bool see(char byte);

  State state_ = State::size;
  std::size_t digits_ = 0, left_ = 0;
};

}  // namespace hoodoo::http
