#include "server/http/encoding.hpp"

#include <brotli/encode.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "engine/base/error.hpp"
#include "server/http/tokens.hpp"
#include "server/http/turn.hpp"

namespace hoodoo::http {
namespace {

constexpr std::size_t least = 1u << 10, least_kept = 16u << 10, most = 8u << 20;  // [bytes]
// Where each takes about as long as reading the file does.
constexpr int gzip_level = 6, brotli_quality = 5, zstd_level = 6;

/// In the order in which they are liked here.
constexpr std::array<std::pair<std::string_view, Coding>, 3> codings{
    {{"br", Coding::br}, {"zstd", Coding::zstd}, {"gzip", Coding::gzip}}};

std::string_view name_of(Coding coding) {
  return std::ranges::find(codings, coding, &decltype(codings)::value_type::second)->first;
}

/// The part of `text` up to `mark`, which `text` then begins after.
std::string_view cut(std::string_view& text, char mark) {
  const auto at = text.find(mark);
  const auto part = text.substr(0, at);
  text.remove_prefix(at == text.npos ? text.size() : at + 1);
  return trimmed(part);
}

/// "q=0.5", in thousandths; nothing where it is no weight (RFC 9110, 12.4.2).
std::optional<int> weight_of(std::string_view parameter) {
  const auto name = cut(parameter, '=');
  double weight = 0;
  const auto* end = parameter.data() + parameter.size();
  const auto [at, error] = std::from_chars(parameter.data(), end, weight, std::chars_format::fixed);
  const bool good =
      same_token(name, "q") && error == std::errc() && at == end && weight >= 0 && weight <= 1;
  return good ? std::optional(static_cast<int>(1000 * weight + 0.5)) : std::nullopt;
}

/// Whether an answer's content gets smaller.
bool is_text(std::string_view type) {
  type = trimmed(type.substr(0, type.find(';')));
  return type.starts_with("text/") || type.ends_with("json") || type == "image/svg+xml" ||
         type == "application/wasm";
}

std::string gzip(std::string_view text) {
  z_stream stream{};
  constexpr int window_of_gzip = 15 + 16, memory = 8;
  if (::deflateInit2(&stream, gzip_level, Z_DEFLATED, window_of_gzip, memory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw Error(Fault::internal, "", "zlib does not begin");
  }
  std::string out(::deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int end = ::deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  if (end != Z_STREAM_END) throw Error(Fault::internal, "", "zlib does not end");
  return out;
}

std::string brotli(std::string_view text) {
  std::size_t size = ::BrotliEncoderMaxCompressedSize(text.size());
  std::string out(size, '\0');
  if (!::BrotliEncoderCompress(brotli_quality, BROTLI_DEFAULT_WINDOW, BROTLI_MODE_TEXT, text.size(),
                               reinterpret_cast<const std::uint8_t*>(text.data()), &size,
                               reinterpret_cast<std::uint8_t*>(out.data()))) {
    throw Error(Fault::internal, "", "brotli does not end");
  }
  out.resize(size);
  return out;
}

std::string zstandard(std::string_view text) {
  std::string out(::ZSTD_compressBound(text.size()), '\0');
  const auto size = ::ZSTD_compress(out.data(), out.size(), text.data(), text.size(), zstd_level);
  if (::ZSTD_isError(size)) throw Error(Fault::internal, "", ::ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::string read(const FilePart& part) {
  std::string text(part.length, '\0');
  for (std::size_t have = 0; have < text.size();) {
    const auto got = ::pread(*part.file, text.data() + have, text.size() - have,
                             static_cast<off_t>(part.offset + have));
    if (got <= 0) throw Error(Fault::internal, "", "a file ends before its end");
    have += static_cast<std::size_t>(got);
  }
  return text;
}

void set_header(Response& response, std::string_view name, std::string value) {
  for (auto& [key, old] : response.headers) {
    if (key == name) {
      old = std::move(value);
      return;
    }
  }
  response.headers.emplace_back(name, std::move(value));
}

bool lists_exactly(std::string_view header, std::string_view etag) {
  bool found = false;
  split(header, ',', [&](std::string_view one) { found = found || trimmed(one) == etag; });
  return found;
}

}  // namespace

Coding coding_of(std::string_view accept_encoding) {
  std::array<std::optional<int>, codings.size()> weights;
  std::optional<int> others;
  while (!accept_encoding.empty()) {
    auto parameters = cut(accept_encoding, ',');
    const auto coding = cut(parameters, ';');
    const auto weight = parameters.empty() ? 1000 : weight_of(trimmed(parameters));
    if (!weight) return Coding::identity;
    if (coding == "*") others = weight;
    for (std::size_t i = 0; i < codings.size(); ++i) {
      const bool is_older_name = codings[i].second == Coding::gzip && same_token(coding, "x-gzip");
      if (same_token(coding, codings[i].first) || is_older_name) weights[i] = weight;
    }
  }
  Coding best = Coding::identity;
  int highest = 0;
  for (std::size_t i = 0; i < codings.size(); ++i) {
    const int weight = weights[i].value_or(others.value_or(0));
    if (weight > highest) {
      highest = weight;
      best = codings[i].second;
    }
  }
  return best;
}

std::string encode(std::string_view text, Coding coding) {
  switch (coding) {
    case Coding::gzip:
      return gzip(text);
    case Coding::br:
      return brotli(text);
    case Coding::zstd:
      return zstandard(text);
    case Coding::identity:
      break;
  }
  return std::string(text);
}

std::string tag_of(std::string_view etag, Coding coding) {
  if (coding == Coding::identity || !etag.ends_with('"')) return std::string(etag);
  etag.remove_suffix(1);
  return std::string(etag) + "-" + std::string(name_of(coding)) + "\"";
}

std::string_view without_coding(std::string_view etag) {
  for (const auto& [name, coding] : codings) {
    const auto end = tag_of("\"", coding);
    if (etag.ends_with(end)) return etag.substr(0, etag.size() - end.size());
  }
  return etag.ends_with('"') ? etag.substr(0, etag.size() - 1) : etag;
}

Encoder::Text Encoder::find(std::string_view tag) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(kept_, tag, &Kept::tag);
  if (found == kept_.end()) return nullptr;
  kept_.splice(kept_.begin(), kept_, found);
  return found->text;
}

void Encoder::keep(const std::string& tag, const Text& text) {
  const std::scoped_lock lock(mutex_);
  kept_.push_front({tag, text});
  kept_bytes_ += text->size();
  while (kept_bytes_ > most_kept_) {
    kept_bytes_ -= kept_.back().text->size();
    kept_.pop_back();
  }
}

Encoder::Text Encoder::encoded(const Response& response, const std::string& tag, Coding coding) {
  const bool is_kept = !tag.empty() && (response.part || response.body.size() >= least_kept);
  if (auto known = is_kept ? find(tag) : nullptr) return known;
  const Turn turn(turns_);
  if (auto known = is_kept ? find(tag) : nullptr) return known;  // somebody else's turn made it
  auto text = std::make_shared<const std::string>(
      encode(response.part ? read(*response.part) : response.body, coding));
  if (is_kept) keep(tag, text);
  return text;
}

void Encoder::apply(const Request& request, Response& response) {
  const auto size = response.part ? response.part->length : response.body.size();
  const bool unchanged = response.status == 304;
  const bool is_wanted = is_text(response.type);
  if (unchanged) response.type.clear();
  if (!is_wanted) return;
  response.headers.emplace_back("Vary", "Accept-Encoding");
  const auto coding = coding_of(request.header("accept-encoding"));
  if (coding == Coding::identity) return;
  const auto tag = tag_of(response.header("ETag"), coding);
  const bool is_known = !tag.empty() && lists_exactly(request.header("if-none-match"), tag);
  if (unchanged) {  // whichever of both the client has
    if (is_known) set_header(response, "ETag", tag);
    return;
  }
  if (response.status != 200 || size < least || size > most) return;
  if (!request.header("range").empty()) return;
  response.text = encoded(response, tag, coding);
  response.body.clear();
  if (response.part) {
    response.part.reset();
    std::erase_if(response.headers,
                  [](const auto& header) { return header.first == "Accept-Ranges"; });
  }
  response.headers.emplace_back("Content-Encoding", name_of(coding));
  if (!tag.empty()) set_header(response, "ETag", tag);
}

}  // namespace hoodoo::http
