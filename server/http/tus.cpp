#include "server/http/tus.hpp"

#include <fmt/chrono.h>
#include <openssl/evp.h>

#include <algorithm>
#include <charconv>
#include <ctime>

#include "engine/base/error.hpp"
#include "server/asset/assets.hpp"

namespace hoodoo::http::tus {
namespace {

constexpr std::size_t most_encoded = 4096;  // [bytes] of one value
constexpr std::string_view uploads = "/uploads";

[[noreturn]] void refuse(const char* header, const char* what) {
  throw Error(Fault::bad_input, header, what);
}

/// None for what is no Base64 with its padding.
std::optional<std::string> decoded(std::string_view text) {
  if (text.size() % 4 != 0 || text.size() > most_encoded) return std::nullopt;
  std::string bytes(text.size() / 4 * 3, '\0');
  const int size = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                                   reinterpret_cast<const unsigned char*>(text.data()),
                                   static_cast<int>(text.size()));
  if (size < 0) return std::nullopt;
  std::size_t padding = 0;
  while (padding < 2 && text.ends_with('=')) {
    text.remove_suffix(1);
    ++padding;
  }
  bytes.resize(static_cast<std::size_t>(size) - padding);
  return bytes;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

bool is_path(std::string_view path) {
  return path.starts_with(uploads) &&
         (path.size() == uploads.size() || path[uploads.size()] == '/');
}

void override_method(Request& request) {
  if (request.method != "POST" || !is_path(request.path)) return;
  const auto wanted = request.header("x-http-method-override");
  if (wanted == "PATCH" || wanted == "DELETE" || wanted == "HEAD") request.method = wanted;
}

std::optional<std::uint64_t> number(std::string_view header) {
  std::uint64_t value = 0;
  const auto* end = header.data() + header.size();
  const auto read = std::from_chars(header.data(), end, value);
  // Offsets of files are signed.
  if (read.ec != std::errc() || read.ptr != end || value > INT64_MAX) return std::nullopt;
  return value;
}

std::optional<Digest> wanted_digest(std::string_view metadata) {
  std::optional<Digest> found;
  while (!metadata.empty()) {
    const auto comma = metadata.find(',');
    const auto pair = trimmed(metadata.substr(0, comma));
    metadata.remove_prefix(comma == metadata.npos ? metadata.size() : comma + 1);
    const auto space = pair.find(' ');
    const auto value = decoded(space == pair.npos ? std::string_view() : pair.substr(space + 1));
    if (pair.empty() || !value) refuse("Upload-Metadata", "must be pairs of a key and Base64");
    if (pair.substr(0, space) != "sha256") continue;
    found = Digest::parse(*value);
    if (!found) found = asset::digest_of(*value);
    if (!found) refuse("Upload-Metadata", "sha256 must be 64 lower-case hexadecimal digits");
  }
  return found;
}

std::optional<Digest> checksum(std::string_view header) {
  if (header.empty()) return std::nullopt;
  constexpr std::string_view algorithm = "sha256 ";
  Digest digest;
  const auto bytes =
      header.starts_with(algorithm) ? decoded(header.substr(algorithm.size())) : std::nullopt;
  if (!bytes || bytes->size() != digest.bytes.size()) {
    refuse("Upload-Checksum", "must be sha256 and the digest in Base64");
  }
  std::ranges::transform(*bytes, digest.bytes.begin(),
                         [](char c) { return static_cast<std::uint8_t>(c); });
  return digest;
}

std::string date(std::chrono::sys_time<std::chrono::seconds> time) {
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT",
                     fmt::gmtime(static_cast<std::time_t>(time.time_since_epoch().count())));
}

}  // namespace hoodoo::http::tus
