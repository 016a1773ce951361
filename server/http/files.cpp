#include "server/http/files.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "server/http/encoding.hpp"
#include "server/http/log.hpp"
#include "server/http/problem.hpp"
#include "server/http/tokens.hpp"

namespace hoodoo::http {
namespace {

constexpr std::size_t most_segments = 16;

using Descriptor = std::shared_ptr<const int>;
Descriptor owned(int file) {
  return {new int(file), [](const int* held) {
            ::close(*held);
            delete held;
          }};
}

bool is_plain(std::string_view segment) {
  constexpr std::string_view allowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  return !segment.empty() && segment.size() <= 255 && segment.front() != '.' &&
         segment.find_first_not_of(allowed) == segment.npos;
}

/// The last segment of a name that may be served, or nothing.
std::string_view last_segment(std::string_view name) {
  for (std::size_t n = 0; n < most_segments; ++n) {
    const auto slash = name.find('/');
    if (!is_plain(name.substr(0, slash))) return {};
    if (slash == name.npos) return name;
    name.remove_prefix(slash + 1);
  }
  return {};
}

/// No symbolic link is followed anywhere below the folder, and nothing leaves it. Errors: errno.
Descriptor open_below(const std::filesystem::path& folder, std::string_view name) {
  const int at = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (at < 0) return nullptr;
  open_how how{};
  how.flags = O_RDONLY | O_NONBLOCK | O_CLOEXEC;
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
  const auto file =
      ::syscall(SYS_openat2, at, std::string(name).c_str(), &how, sizeof how);  // glibc has no name
  const int error = errno;
  ::close(at);
  errno = error;
  return file < 0 ? nullptr : owned(static_cast<int>(file));
}

/// There is no such file, or none that is anybody's to read; else something is wrong here.
bool is_absence(int error) {
  constexpr std::array absences{ENOENT, ENOTDIR, EISDIR,       ELOOP, EXDEV,
                                EACCES, EPERM,   ENAMETOOLONG, ENXIO};
  return std::ranges::find(absences, error) != absences.end();
}

/// True for a name that the SHA-256 of a tile or an asset makes.
bool is_content_addressed(std::string_view stem) {
  constexpr std::string_view asset = "sha256-";
  if (stem.starts_with(asset)) stem.remove_prefix(asset.size());
  return stem.size() == 64 && stem.find_first_not_of("0123456789abcdef") == stem.npos;
}

/// Files are replaced by a rename and never written in place, so inode, size and time tell two
/// contents of one name apart; `offset` those of one archive.
std::string etag_of(std::string_view stem, const struct stat& status, std::uint64_t offset) {
  if (is_content_addressed(stem)) return fmt::format("\"{}\"", stem);
  const auto inside = offset == 0 ? "" : fmt::format("-{:x}", offset);
  return fmt::format("\"{:x}-{:x}-{:x}.{:x}{}\"", status.st_ino, status.st_size,
                     status.st_mtim.tv_sec, status.st_mtim.tv_nsec, inside);
}

struct Range {
  enum class Kind { none, part, refused } kind = Kind::none;
  std::uint64_t offset = 0, length = 0;
};

/// The largest there is for what is larger.
std::optional<std::uint64_t> number(std::string_view digits) {
  if (digits.empty() || digits.find_first_not_of("0123456789") != digits.npos) return std::nullopt;
  std::uint64_t value = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return read.ec == std::errc() ? value : std::numeric_limits<std::uint64_t>::max();
}

/// One of "0-4", "5-", "-6"; `none` when it is no such thing.
Range one_range(std::string_view text, std::uint64_t size) {
  const auto dash = text.find('-');
  if (dash == text.npos) return {};
  const auto before = text.substr(0, dash), after = text.substr(dash + 1);
  const auto first = number(before), last = number(after);
  const Range outside{Range::Kind::refused, 0, 0};
  if (before.empty()) {
    if (!last) return {};
    const auto length = std::min(*last, size);  // the last bytes
    return length == 0 ? outside : Range{Range::Kind::part, size - length, length};
  }
  if (!first || (!last && !after.empty()) || (last && *last < *first)) return {};
  if (*first >= size) return outside;
  const auto end = last ? std::min(*last, size - 1) : size - 1;
  return {Range::Kind::part, *first, end - *first + 1};
}

/// RFC 9110, 14.1.2 and 14.2. Other units, and what is malformed, are ignored.
Range range_of(std::string_view header, std::uint64_t size) {
  const auto equals = header.find('=');
  if (equals == header.npos || !same_token(header.substr(0, equals), "bytes")) return {};
  Range range;
  int count = 0;
  bool well = true;
  split(header.substr(equals + 1), ',', [&](std::string_view one) {
    range = one_range(trimmed(one), size);
    well = well && range.kind != Range::Kind::none;
    ++count;
  });
  if (!well) return {};
  return count == 1 ? range : Range{Range::Kind::refused, 0, 0};
}

Response not_found() { return problem(404, "There is no such file."); }

Response not_opened(int error, std::string_view name, const Request& request) {
  if (is_absence(error)) return not_found();
  log_fault(fmt::format("{}: cannot be read: {}", name, std::system_category().message(error)),
            request.id);
  auto refused = problem(503, "The file cannot be read now.");
  refused.headers.emplace_back("Retry-After", "1");
  return refused;
}

}  // namespace

std::string type_of(std::string_view extension) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 11> types{
      {{".glb", "model/gltf-binary"},
       {".json", "application/json"},
       {".html", "text/html; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".wasm", "application/wasm"},
       {".svg", "image/svg+xml"},
       {".png", "image/png"},
       {".tif", "image/tiff; application=geotiff"},
       {".csv", "text/csv; charset=utf-8"},
       {".txt", "text/plain; charset=utf-8"}}};
  for (const auto& [known, type] : types) {
    if (known == extension) return std::string(type);
  }
  return "application/octet-stream";
}

/// What is the same in one coding is so in all.
bool lists(std::string_view header, std::string_view etag, Comparison comparison) {
  bool found = header == "*";
  split(header, ',', [&](std::string_view one) {
    one = trimmed(one);
    if (comparison == Comparison::weak && one.starts_with("W/")) one.remove_prefix(2);
    found = found || without_coding(one) == without_coding(etag);
  });
  return found;
}

bool is_plain_name(std::string_view name) { return is_plain(name); }

bool may_be_served(std::string_view name, std::span<const std::string_view> extensions) {
  const auto last = last_segment(name);
  if (last.empty()) return false;
  const auto extension = std::filesystem::path(last).extension().string();
  return std::ranges::find(extensions, extension) != extensions.end();
}

Response serve_part(const FilePart& part, std::string_view name, const Request& request) {
  struct stat status {};
  if (::fstat(*part.file, &status) != 0) return not_opened(errno, name, request);
  const std::filesystem::path last(name);
  const auto extension = last.extension().string(), stem = last.stem().string();
  const auto etag = etag_of(stem, status, part.offset);
  Response response;
  response.headers = {
      {"ETag", etag},
      {"Accept-Ranges", "bytes"},
      {"Cache-Control",
       is_content_addressed(stem) ? "public, max-age=31536000, immutable" : "no-cache"}};
  response.type = type_of(extension);
  if (lists(request.header("if-none-match"), etag)) {
    response.status = 304;
    return response;
  }
  response.part = part;
  const auto condition = request.header("if-range");
  if (request.method != "GET" || (!condition.empty() && condition != etag)) return response;
  const auto range = range_of(request.header("range"), part.length);
  if (range.kind == Range::Kind::refused) {
    auto refusal = problem(416, "Ask for one range of bytes inside the file.");
    refusal.headers.emplace_back("Content-Range", fmt::format("bytes */{}", part.length));
    return refusal;
  }
  if (range.kind == Range::Kind::part) {
    response.status = 206;
    response.part = FilePart{part.file, part.offset + range.offset, range.length};
    response.headers.emplace_back(
        "Content-Range",
        fmt::format("bytes {}-{}/{}", range.offset, range.offset + range.length - 1, part.length));
  }
  return response;
}

Response serve_file(const Folder& folder, std::string_view name, const Request& request) {
  if (!may_be_served(name, folder.extensions)) return not_found();
  const auto file = open_below(folder.path, name);
  struct stat status {};
  if (!file || ::fstat(*file, &status) != 0) return not_opened(errno, name, request);
  if (!S_ISREG(status.st_mode)) return not_found();
  return serve_part({file, 0, static_cast<std::uint64_t>(status.st_size)}, name, request);
}

}  // namespace hoodoo::http
