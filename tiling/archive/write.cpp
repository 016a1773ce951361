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

std::uint32_t narrow(std::uint64_t value) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(value, zip::full32));
}

}  // namespace

Writer::Writer(const std::filesystem::path& file, std::uint64_t start) : file_(file) {
  file_.seek(start);
}

void Writer::add(const std::string& name, std::span<const std::byte> bytes) {
  if (bytes.size() >= zip::full32 || name.size() >= zip::full16) {
    throw Error(Fault::limit, name, "has 4 GiB or more, which a .3tz cannot hold");
  }
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const Entry entry{name, crc_of(bytes), size, file_.position()};
  zip::LocalHeader header;
  header.crc = entry.crc;
  header.packed = header.size = size;
  header.name = static_cast<std::uint16_t>(name.size());
  file_.put(header);
  file_.write(name);
  file_.write(bytes);
  entries_.push_back(entry);
}

void Writer::add_index() {
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
  add(std::string(zip::index_name), std::as_bytes(std::span(index)));
}

void Writer::write_directory() {
  for (const auto& entry : entries_) {
    zip::DirectoryHeader header;
    const bool wide = entry.offset >= zip::full32;
    if (wide) header.version = zip::wide_version;
    header.crc = entry.crc;
    header.packed = header.size = entry.size;
    header.name = static_cast<std::uint16_t>(entry.name.size());
    header.extra = wide ? sizeof(zip::WideOffset) : 0;
    header.offset = narrow(entry.offset);
    file_.put(header);
    file_.write(entry.name);
    if (wide) {
      zip::WideOffset extra;
      extra.offset = entry.offset;
      file_.put(extra);
    }
  }
}

void Writer::finish() {
  add_index();
  const auto offset = file_.position();
  write_directory();
  const auto size = file_.position() - offset, count = std::uint64_t{entries_.size()};
  if (count >= zip::full16 || size >= zip::full32 || offset >= zip::full32) {
    zip::WideEnd wide;
    wide.entries_here = wide.entries = count;
    wide.size = size;
    wide.offset = offset;
    zip::WideEndLocator locator;
    locator.offset = file_.position();
    file_.put(wide);
    file_.put(locator);
  }
  zip::End end;
  end.entries_here = end.entries =
      static_cast<std::uint16_t>(std::min<std::uint64_t>(count, zip::full16));
  end.size = narrow(size);
  end.offset = narrow(offset);
  file_.put(end);
  file_.commit();
}

}  // namespace hoodoo::archive
