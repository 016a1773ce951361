#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "engine/base/error.hpp"
#include "tiling/archive/zip.hpp"

namespace hoodoo::archive {
namespace {

Error refused(const std::filesystem::path& path, std::string why) {
  return {Fault::bad_input, path.string(), std::move(why)};
}

/// The one of the 64-bit extension, where the record's own is full.
std::uint64_t offset_of(const zip::DirectoryHeader& header, std::string_view extra) {
  if (header.offset != zip::full32) return header.offset;
  while (extra.size() >= 4) {
    const auto tag = zip::record_of<std::uint16_t>(extra);
    const std::size_t length = zip::record_of<std::uint16_t>(extra.substr(2));
    extra.remove_prefix(4);
    if (length > extra.size()) break;
    // Sizes stand there before the offset, each only if its own record's is full.
    const std::size_t before =
        8U * ((header.size == zip::full32 ? 1U : 0U) + (header.packed == zip::full32 ? 1U : 0U));
    if (tag == zip::wide_tag && length >= before + 8) {
      return zip::record_of<std::uint64_t>(extra.substr(before));
    }
    extra.remove_prefix(length);
  }
  return header.offset;
}

}  // namespace

Archive::Archive(const std::filesystem::path& file) : path_(file) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (opened < 0) {
    throw Error(errno == ENOENT ? Fault::not_found : Fault::io, file.string(),
                "cannot be opened: " + std::generic_category().message(errno));
  }
  file_ = {new int(opened), [](const int* held) {
             ::close(*held);
             delete held;
           }};
  struct stat status {};
  if (::fstat(opened, &status) != 0 || !S_ISREG(status.st_mode)) throw refused(file, "is no file");
  size_ = static_cast<std::uint64_t>(status.st_size);

  const auto at = find_index(find_directory());
  const auto part = entry_at(at, zip::index_name);
  if (!part || part->length % sizeof(zip::IndexEntry) != 0) {
    throw refused(file, "has a damaged index");
  }
  const auto text = read(*part);
  for (std::size_t from = 0; from < text.size(); from += sizeof(zip::IndexEntry)) {
    const auto entry = zip::record_of<zip::IndexEntry>(std::string_view(text).substr(from));
    index_.push_back({std::to_array(entry.md5), entry.offset});
  }
  const auto by_md5 = [](const Place& a, const Place& b) { return zip::before(a.md5, b.md5); };
  if (!std::ranges::is_sorted(index_, by_md5)) throw refused(file, "has an index out of order");
  if (!find("tileset.json")) throw refused(file, "holds no tileset.json");
}

std::string Archive::bytes(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size_ || length > size_ - offset) throw refused(path_, "is damaged or cut short");
  std::string text(length, '\0');
  for (std::size_t done = 0; done < length;) {
    const auto got =
        ::pread(*file_, text.data() + done, length - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw Error(Fault::io, path_.string(),
                  "cannot be read: " + std::generic_category().message(errno));
    }
    if (got == 0) throw refused(path_, "is damaged or cut short");
    done += static_cast<std::size_t>(got);
  }
  return text;
}

std::string Archive::read(const Part& part) const { return bytes(part.offset, part.length); }

/// Its end record is the last of the file, but for a comment of up to 64 KiB.
Archive::Directory Archive::find_directory() const {
  const auto length = std::min<std::uint64_t>(size_, sizeof(zip::End) + zip::full16);
  const auto start = size_ - length;
  const auto tail = bytes(start, length);
  const auto at = tail.rfind("PK\5\6");
  if (at == tail.npos || tail.size() - at < sizeof(zip::End)) {
    throw refused(path_, "is no ZIP file");
  }
  const auto end = zip::record_of<zip::End>(std::string_view(tail).substr(at));
  if (at >= sizeof(zip::WideEndLocator)) {
    const auto locator = zip::record_of<zip::WideEndLocator>(
        std::string_view(tail).substr(at - sizeof(zip::WideEndLocator)));
    if (locator.signature == zip::WideEndLocator{}.signature) {
      const auto wide = zip::record_of<zip::WideEnd>(bytes(locator.offset, sizeof(zip::WideEnd)));
      if (wide.signature != zip::WideEnd{}.signature) throw refused(path_, "is damaged");
      return {wide.offset, wide.size};
    }
  }
  return {end.offset, end.size};
}

/// Where the index has its local header. It is the last entry of the directory, which is searched
/// from its end.
std::uint64_t Archive::find_index(const Directory& directory) const {
  constexpr std::uint64_t most = 4096;
  const auto length = std::min(directory.size, most);
  if (directory.size > size_ || directory.offset > size_ - directory.size) {
    throw refused(path_, "is damaged or cut short");
  }
  const auto tail = bytes(directory.offset + directory.size - length, length);
  const auto name = tail.rfind(zip::index_name);
  if (name != tail.npos && name >= sizeof(zip::DirectoryHeader)) {
    const auto text = std::string_view(tail).substr(name - sizeof(zip::DirectoryHeader));
    const auto header = zip::record_of<zip::DirectoryHeader>(text);
    const auto rest = text.substr(sizeof header);
    if (header.signature == zip::DirectoryHeader{}.signature &&
        header.name == zip::index_name.size() &&
        rest.size() >= std::size_t{header.name} + header.extra) {
      return offset_of(header, rest.substr(header.name, header.extra));
    }
  }
  throw refused(path_, "has no index @3dtilesIndex1@ at its end, so it is no .3tz");
}

std::optional<Archive::Part> Archive::entry_at(std::uint64_t offset, std::string_view name) const {
  const auto header = zip::record_of<zip::LocalHeader>(bytes(offset, sizeof(zip::LocalHeader)));
  if (header.signature != zip::LocalHeader{}.signature) throw refused(path_, "is damaged");
  const auto data = offset + sizeof header;
  if (bytes(data, header.name) != name) return std::nullopt;
  if (header.method != zip::stored) {
    throw refused(path_, std::string(name) + " is compressed; only stored files can be read");
  }
  const Part part{data + header.name + header.extra, header.size, header.crc};
  if (part.offset > size_ || part.length > size_ - part.offset) {
    throw refused(path_, "is damaged or cut short");
  }
  return part;
}

std::optional<Archive::Part> Archive::find(std::string_view name) const {
  const auto wanted = zip::md5(name);
  auto at = std::ranges::lower_bound(index_, wanted, zip::before, &Place::md5);
  for (; at != index_.end() && at->md5 == wanted; ++at) {
    if (const auto part = entry_at(at->offset, name)) return part;
  }
  return std::nullopt;
}

}  // namespace hoodoo::archive
