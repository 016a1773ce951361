#include "tiling/store/cache.hpp"

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

namespace hoodoo::store {
namespace {

constexpr std::uintmax_t most_entry_bytes = (std::uintmax_t{1} << 30) + (1 << 20);
/// An entry is this line, the record's line, and the tile; the digest is of all after its line.
constexpr std::string_view heading = "hoodoo tile 1 ";

/// The part of `text` up to a line's end, which is taken off with it.
std::optional<std::string_view> take_line(std::string_view& text) {
  const auto end = text.find('\n');
  if (end == text.npos) return std::nullopt;
  const auto line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return line;
}

}  // namespace

std::filesystem::path Cache::path_of(const Digest& slice) const {
  const auto hex = slice.hex();
  return folder_ / hex.substr(0, 2) / (hex + ".tile");
}

bool Cache::has(const Digest& slice) const {
  std::error_code error;
  return std::filesystem::is_regular_file(path_of(slice), error);
}

std::optional<Cache::Entry> Cache::get(const Digest& slice) const {
  if (!has(slice)) return std::nullopt;
  try {
    const auto text = read_file(path_of(slice), most_entry_bytes);
    std::string_view rest = text;
    const auto first = take_line(rest);
    if (!first || *first != std::string(heading) + sha256(rest).hex()) return std::nullopt;
    const auto record = take_line(rest);
    if (!record) return std::nullopt;
    const auto tile = std::as_bytes(std::span(rest));
    return Entry{std::string(*record), {tile.begin(), tile.end()}};
  } catch (const Error&) {
    return std::nullopt;  // unreadable, or replaced by something else
  }
}

void Cache::put(const Digest& slice, std::string_view record, std::span<const std::byte> tile) {
  if (failed_) return;
  std::string rest(record);
  rest += '\n';
  rest.append(reinterpret_cast<const char*>(tile.data()), tile.size());
  try {
    write_file(path_of(slice), std::string(heading) + sha256(rest).hex() + '\n' + rest);
  } catch (const Error& error) {
    failed_ = true;
    const std::lock_guard lock(mutex_);
    const auto& problem = error.problems.front();
    warning_ = "the cache is not written: " + problem.where + ": " + problem.what;
  }
}

std::string Cache::warning() const {
  const std::lock_guard lock(mutex_);
  return warning_;
}

}  // namespace hoodoo::store
