#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "tiling/archive/archive.hpp"

/// The records of a ZIP file as they lie in it. Source: PKWARE APPNOTE 6.3.9, section 4.3.
namespace hoodoo::archive::zip {

static_assert(std::endian::native == std::endian::little, "ZIP is little-endian");

inline constexpr std::string_view index_name = "@3dtilesIndex1@";
inline constexpr std::uint32_t full32 = 0xFFFFFFFF;  // "stands in the 64-bit extension"
inline constexpr std::uint16_t full16 = 0xFFFF;
inline constexpr std::uint16_t wide_tag = 1;  // of the 64-bit extension among extra fields
inline constexpr std::uint16_t plain_version = 20, wide_version = 45;  // of the format
inline constexpr std::uint16_t unix_ = 3 << 8;                         // host of attributes
inline constexpr std::uint16_t stored = 0;                             // compression method
inline constexpr std::uint16_t utf8 = 1 << 11;
inline constexpr std::uint16_t first_day = 1 << 5 | 1;  // 1980-01-01, where its time starts

#pragma pack(push, 1)
struct LocalHeader {
  std::uint32_t signature = 0x04034b50;
  std::uint16_t version = plain_version, flags = utf8, method = stored, time = 0, day = first_day;
  std::uint32_t crc = 0, packed = 0, size = 0;
  std::uint16_t name = 0, extra = 0;  // [bytes]
};
struct DirectoryHeader {
  std::uint32_t signature = 0x02014b50;
  std::uint16_t made_by = unix_ | wide_version, version = plain_version;
  std::uint16_t flags = utf8, method = stored, time = 0, day = first_day;
  std::uint32_t crc = 0, packed = 0, size = 0;
  std::uint16_t name = 0, extra = 0, comment = 0;  // [bytes]
  std::uint16_t disk = 0, inner = 0;
  std::uint32_t outer = 0100644U << 16;  // a plain file
  std::uint32_t offset = 0;
};
struct WideOffset {
  std::uint16_t tag = wide_tag, length = 8;
  std::uint64_t offset = 0;
};
struct WideEnd {
  std::uint32_t signature = 0x06064b50;
  std::uint64_t length = 44;  // of what follows
  std::uint16_t made_by = unix_ | wide_version, version = wide_version;
  std::uint32_t disk = 0, directory_disk = 0;
  std::uint64_t entries_here = 0, entries = 0, size = 0, offset = 0;
};
struct WideEndLocator {
  std::uint32_t signature = 0x07064b50;
  std::uint32_t disk = 0;
  std::uint64_t offset = 0;
  std::uint32_t disks = 1;
};
struct End {
  std::uint32_t signature = 0x06054b50;
  std::uint16_t disk = 0, directory_disk = 0, entries_here = 0, entries = 0;
  std::uint32_t size = 0, offset = 0;
  std::uint16_t comment = 0;  // [bytes]
};
struct IndexEntry {
  std::uint8_t md5[16];
  std::uint64_t offset;
};
#pragma pack(pop)
static_assert(sizeof(LocalHeader) == 30 && sizeof(DirectoryHeader) == 46 && sizeof(WideEnd) == 56 &&
              sizeof(WideEndLocator) == 20 && sizeof(End) == 22 && sizeof(IndexEntry) == 24);

/// The record that `text` starts with; it must be long enough.
template <class Record>
Record record_of(std::string_view text) {
  Record record;
  std::memcpy(&record, text.data(), sizeof record);
  return record;
}

std::array<std::uint8_t, 16> md5(std::string_view text);

/// The order of the index: both halves of the MD5 as little-endian numbers.
bool before(const std::array<std::uint8_t, 16>& a, const std::array<std::uint8_t, 16>& b);

}  // namespace hoodoo::archive::zip
