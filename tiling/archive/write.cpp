#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>

#include "engine/base/error.hpp"
#include "tiling/archive/zip.hpp"

namespace hoodoo::archive {

namespace zip {

std::array<std::uint8_t, 16> md5(std::string_view text) {
  std::array<std::uint8_t, 16> digest{};
  if (EVP_Digest(text.data(), text.size(), digest.data(), nullptr, EVP_md5(), nullptr) != 1) {
    throw Error(Fault::internal, "", "OpenSSL has no MD5, which names the files of a .3tz");
  }
  return digest;
}

bool before(const std::array<std::uint8_t, 16>& a, const std::array<std::uint8_t, 16>& b) {
  return std::bit_cast<std::array<std::uint64_t, 2>>(a) <
         std::bit_cast<std::array<std::uint64_t, 2>>(b);
}

}  // namespace zip

namespace {

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
  return static_cast<std::uint32_t>(crc32_z(crc32_z(0, nullptr, 0), data, bytes.size()));
}

template <class Record>
void put(std::string& text, const Record& record) {
  text.append(reinterpret_cast<const char*>(&record), sizeof record);
}

std::uint32_t narrow(std::uint64_t value) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(value, zip::full32));
}

}  // namespace

std::string Records::head(const std::string& name, std::span<const std::byte> bytes) {
  if (bytes.size() >= zip::full32 || name.size() >= zip::full16) {
    throw Error(Fault::limit, name, "has 4 GiB or more, which a .3tz cannot hold");
  }
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const Entry entry{name, crc_of(bytes), size, position_};
  zip::LocalHeader header;
  header.crc = entry.crc;
  header.packed = header.size = size;
  header.name = static_cast<std::uint16_t>(name.size());
  entries_.push_back(entry);
  std::string text;
  put(text, header);
  text += name;
  position_ += text.size() + bytes.size();
  return text;
}

std::string Records::index() const {
  std::vector<Place> places;
  for (const auto& entry : entries_) places.push_back({zip::md5(entry.name), entry.offset});
  std::ranges::sort(places, [](const Place& a, const Place& b) {
    return zip::before(a.md5, b.md5) || (a.md5 == b.md5 && a.offset < b.offset);
  });
  std::vector<zip::IndexEntry> index(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::ranges::copy(places[i].md5, index[i].md5);
    index[i].offset = places[i].offset;
  }
  std::string text;
  for (const auto& entry : index) put(text, entry);
  return text;
}

std::string Records::directory() const {
  std::string text;
  for (const auto& entry : entries_) {
    zip::DirectoryHeader header;
    const bool wide = entry.offset >= zip::full32;
    if (wide) header.version = zip::wide_version;
    header.crc = entry.crc;
    header.packed = header.size = entry.size;
    header.name = static_cast<std::uint16_t>(entry.name.size());
    header.extra = wide ? sizeof(zip::WideOffset) : 0;
    header.offset = narrow(entry.offset);
    put(text, header);
    text += entry.name;
    if (wide) {
      zip::WideOffset extra;
      extra.offset = entry.offset;
      put(text, extra);
    }
  }
  return text;
}

std::string Records::end() {
  const auto index = this->index();
  auto text = head(std::string(zip::index_name), std::as_bytes(std::span(index))) + index;
  const auto offset = position_;
  const auto directory = this->directory();
  text += directory;
  const auto size = std::uint64_t{directory.size()}, count = std::uint64_t{entries_.size()};
  if (count >= zip::full16 || size >= zip::full32 || offset >= zip::full32) {
    zip::WideEnd wide;
    wide.entries_here = wide.entries = count;
    wide.size = size;
    wide.offset = offset;
    zip::WideEndLocator locator;
    locator.offset = offset + size;
    put(text, wide);
    put(text, locator);
  }
  zip::End end;
  end.entries_here = end.entries =
      static_cast<std::uint16_t>(std::min<std::uint64_t>(count, zip::full16));
  end.size = narrow(size);
  end.offset = narrow(offset);
  put(text, end);
  return text;
}

Writer::Writer(const std::filesystem::path& file, std::uint64_t start)
    : file_(file), records_(start) {
  file_.seek(start);
}

void Writer::add(const std::string& name, std::span<const std::byte> bytes) {
  file_.write(records_.head(name, bytes));
  file_.write(bytes);
}

void Writer::finish() {
  file_.write(records_.end());
  file_.commit();
}

}  // namespace hoodoo::archive
