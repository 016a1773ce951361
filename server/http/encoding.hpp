#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <semaphore>
#include <string>
#include <string_view>

#include "server/http/message.hpp"

/// Content codings of answers: RFC 9110, 8.4 and 12.5.3; RFC 1952, 7932 and 8878.
namespace hoodoo::http {

enum class Coding : std::uint8_t { identity, gzip, br, zstd };

/// The coding that a header Accept-Encoding likes best; of equals br, zstd, gzip. No coding where
/// there is no header, or where it can't be understood.
Coding coding_of(std::string_view accept_encoding);

/// `text` in a coding; the same bytes for the same text.
std::string encode(std::string_view text, Coding coding);

/// The entity tag of content in a coding, which is not that of the content itself: "x" becomes
/// "x-br".
std::string tag_of(std::string_view etag, Coding coding);
/// The same of all of its codings.
std::string_view without_coding(std::string_view etag);

/// Puts answers into the coding that their clients like best.
///
/// What of JSON, text, script and drawings has 1 KiB to 8 MiB, of a whole answer (200) to a request
/// without a range. Files and large documents are encoded once and kept in memory, up to
/// `most_kept` bytes; the least used goes first. A few are encoded at a time, and what is kept is
/// sent from where it is, so that a crowd takes the memory of a few.
class Encoder {
 public:
  explicit Encoder(std::size_t most_kept = 16u << 20) : most_kept_(most_kept) {}

  void apply(const Request& request, Response& response);

 private:
  using Text = std::shared_ptr<const std::string>;
  struct Kept {
    std::string tag;
    Text text;
  };

  Text find(std::string_view tag);
  void keep(const std::string& tag, const Text& text);
  Text encoded(const Response& response, const std::string& tag, Coding coding);

  const std::size_t most_kept_;
  std::counting_semaphore<> turns_{2};
  std::mutex mutex_;
  std::list<Kept> kept_;  // the last used first
  std::size_t kept_bytes_ = 0;
};

}  // namespace hoodoo::http
