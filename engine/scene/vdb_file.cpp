#include "engine/scene/vdb_file.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace hoodoo::scene::vdb {
namespace {

constexpr std::string_view magic("\x20\x42\x44\x56\0\0\0\0", 8);
constexpr std::string_view float_type = "Tree_float_5_4_3", half_suffix = "_HalfFloat";
constexpr char separator = '\x1e';  // between a grid's name and its number among namesakes
constexpr std::uint32_t longest_text = 4096;
constexpr std::uint32_t most_items = 10'000;  // grids of a file, metadata of a grid

std::string shown(const std::string& name) { return name.substr(0, 80); }

}  // namespace

void refuse(std::string what) { throw Refused{std::move(what)}; }
void damaged() { throw Refused{"is damaged or cut short"}; }

Source::Source(const std::filesystem::path& file) : in_(file, std::ios::binary) {
  if (!in_) refuse("cannot be read");
  in_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  in_.seekg(0, std::ios::end);
  size_ = in_.tellg();
  in_.seekg(0);
}

std::string Source::text() {
  const auto size = get<std::uint32_t>();
  if (size > longest_text) damaged();
  std::string text(size, '\0');
  in_.read(text.data(), size);
  return text;
}

void Source::seek(std::int64_t place) {
  if (place < 0 || place > size_) damaged();
  in_.seekg(place);
}

void Source::skip_metadata() {
  const auto count = get<std::uint32_t>();
  if (count > most_items) damaged();
  for (std::uint32_t i = 0; i < count; ++i) {
    text();  // name
    text();  // type
    const auto size = get<std::uint32_t>();
    seek(place() + size);
  }
}

std::string Entry::name() const { return unique.substr(0, unique.find(separator)); }

bool Entry::half() const { return type.ends_with(half_suffix); }

bool Entry::fits() const {
  const auto plain = type.size() - (half() ? half_suffix.size() : 0);
  return std::string_view(type).substr(0, plain) == float_type;
}

std::string Entry::numbers() const {
  const auto from = type.find('_');
  return from == type.npos ? type : type.substr(from + 1, type.find('_', from + 1) - from - 1);
}

Listing read_listing(Source& from, std::uint32_t oldest, std::uint32_t newest) {
  std::array<char, 8> head{};
  try {
    head = from.get<std::array<char, 8>>();
  } catch (const std::ios_base::failure&) {
    refuse("is no OpenVDB file");  // shorter than that
  }
  if (std::string_view(head.data(), head.size()) != magic) refuse("is no OpenVDB file");
  Listing listing{};
  listing.format = from.get<std::uint32_t>();
  if (listing.format < oldest || listing.format > newest) {
    refuse(fmt::format("has OpenVDB format {}, must be {} to {}", listing.format, oldest, newest));
  }
  listing.library_major = from.get<std::uint32_t>();
  listing.library_minor = from.get<std::uint32_t>();
  if (from.get<char>() == 0) refuse("was written as a stream, without the places of its grids");
  from.get<std::array<char, 36>>();  // its UUID
  from.skip_metadata();
  const auto count = from.get<std::uint32_t>();
  if (count > most_items) damaged();
  for (std::uint32_t i = 0; i < count; ++i) {
    Entry one;
    one.unique = from.text();
    one.type = from.text();
    one.parent = from.text();
    one.start = from.get<std::int64_t>();
    from.get<std::int64_t>();  // of its values
    from.seek(from.get<std::int64_t>());
    listing.grids.push_back(std::move(one));
  }
  return listing;
}

const Entry& choose(const std::vector<Entry>& grids, const std::string& name) {
  std::string all;
  for (const Entry& one : grids) {
    if (name.empty() ? one.fits() : one.name() == name || one.unique == name) {
      if (one.fits()) return one;
      throw Refused{fmt::format("has numbers of type {} in its grid \"{}\", must be float",
                                shown(one.numbers()), shown(name)),
                    true};
    }
    if (all.size() > 500) continue;
    all += fmt::format("{}\"{}\" ({})", all.empty() ? "" : ", ", shown(one.name()),
                       shown(one.numbers()));
  }
  if (all.empty()) refuse("has no grid");
  if (name.empty()) refuse("has no grid of type float, but " + all);
  throw Refused{fmt::format("has no grid \"{}\", but {}", shown(name), all), true};
}

}  // namespace hoodoo::scene::vdb
