#include "tiling/archive/archive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/tiling/tileset/world.hpp"
#include "tiling/archive/zip.hpp"

namespace hoodoo::archive {
namespace {

namespace fs = std::filesystem;
using shapes::Folder;
using testing::HasSubstr;

constexpr std::uintmax_t most = 1 << 30;

struct Archives : testing::Test {
  Folder folder{"archive"};
  fs::path file = folder.path / "a.3tz";

  static void add(Writer& writer, const std::string& name, std::string_view text) {
    writer.add(name, std::as_bytes(std::span(text)));
  }
  void write(std::uint64_t start = 0) const {
    Writer writer(file, start);
    add(writer, "tileset.json", "{}");
    add(writer, "tiles/ab/one.glb", "one");
    add(writer, "tiles/cd/none.glb", "");
    writer.finish();
  }
  std::string text_of(const std::string& name) const {
    const Archive archive(file);
    const auto part = archive.find(name);
    return part ? archive.read(*part) : "(absent)";
  }
  Error refusal() const {
    try {
      const Archive archive(file);
    } catch (const Error& error) {
      return error;
    }
    return {Fault::internal, "", "was not refused"};
  }
  /// Writes `bytes` over what the file has after the first `mark`.
  void damage(std::string_view mark, std::size_t after, std::string_view bytes) const {
    auto text = read_file(file, most);
    text.replace(text.find(mark) + after, bytes.size(), bytes);
    write_file(file, text);
  }
};

TEST_F(Archives, GiveBackWhatWasPutIn) {
  write();
  EXPECT_EQ(text_of("tileset.json"), "{}");
  EXPECT_EQ(text_of("tiles/ab/one.glb"), "one");
  EXPECT_EQ(text_of("tiles/cd/none.glb"), "");
  EXPECT_EQ(text_of("tiles/ab/two.glb"), "(absent)");
  EXPECT_EQ(Archive(file).entries(), 3U);
}

TEST_F(Archives, HaveTheSameBytesForTheSameFiles) {
  write();
  const auto first = read_file(file, most);
  write();
  EXPECT_EQ(read_file(file, most), first);
}

TEST_F(Archives, EndWithAnIndexInTheOrderOfTheSpecification) {
  write();
  const auto text = read_file(file, most);
  const auto end = zip::record_of<zip::End>(std::string_view(text).substr(text.size() - 22));
  ASSERT_EQ(std::uint16_t{end.entries}, 4);    // a copy: records are packed
  const auto at = text.find(zip::index_name);  // in its local header
  const auto header = zip::record_of<zip::LocalHeader>(
      std::string_view(text).substr(at - sizeof(zip::LocalHeader)));
  ASSERT_EQ(std::uint32_t{header.size}, 3 * 24U);
  std::vector<std::uint64_t> halves;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto entry = std::string_view(text).substr(at + zip::index_name.size() + 24 * i, 24);
    halves.push_back(zip::record_of<std::uint64_t>(entry));
    const auto offset = zip::record_of<std::uint64_t>(entry.substr(16));
    EXPECT_EQ(text.substr(offset, 4), "PK\3\4");
  }
  EXPECT_TRUE(std::ranges::is_sorted(halves));
  EXPECT_TRUE(text.ends_with(std::string_view("\0\0", 2))) << "no comment";
}

TEST_F(Archives, NameFilesByTheirMd5) {
  const auto digest = zip::md5("abc");  // RFC 1321, A.5
  EXPECT_THAT(digest, testing::ElementsAre(0x90, 0x01, 0x50, 0x98, 0x3c, 0xd2, 0x4f, 0xb0, 0xd6,
                                           0x96, 0x3f, 0x7d, 0x28, 0xe1, 0x7f, 0x72));
}

TEST_F(Archives, CompareHalvesAsLittleEndianNumbers) {
  std::array<std::uint8_t, 16> low{}, high{};
  low[0] = 255;  // the least significant byte
  high[7] = 1;   // the most significant one
  EXPECT_TRUE(zip::before(low, high));
  EXPECT_FALSE(zip::before(high, low));
}

TEST_F(Archives, ReachBeyondFourGigabytes) {
  write(std::uint64_t{5} << 30);  // what is before takes no room on disk
  EXPECT_GT(fs::file_size(file), std::uint64_t{5} << 30);
  EXPECT_EQ(text_of("tileset.json"), "{}");
  EXPECT_EQ(text_of("tiles/ab/one.glb"), "one");
}

TEST_F(Archives, HoldMoreFilesThanSixteenBitsCount) {
  constexpr int count = 70'000;
  Writer writer(file);
  add(writer, "tileset.json", "{}");
  for (int i = 0; i < count; ++i) add(writer, "tiles/" + std::to_string(i), std::to_string(i));
  writer.finish();
  const Archive archive(file);
  EXPECT_EQ(archive.entries(), count + 1U);
  for (int i = 0; i < count; i += 999) {
    const auto part = archive.find("tiles/" + std::to_string(i));
    ASSERT_TRUE(part.has_value()) << i;
    EXPECT_EQ(archive.read(*part), std::to_string(i));
  }
}

TEST_F(Archives, AreNotThereUntilTheyAreWhole) {
  {
    Writer writer(file);
    add(writer, "tileset.json", "{}");
  }
  EXPECT_TRUE(fs::is_empty(folder.path));
}

TEST_F(Archives, ThatAreNoneAreRefused) {
  EXPECT_EQ(refusal().fault, Fault::not_found);
  write_file(file, "no archive");
  EXPECT_THAT(refusal().what(), HasSubstr("is no ZIP file"));
  EXPECT_EQ(refusal().fault, Fault::bad_input);
  Writer writer(file);
  add(writer, "bake.json", "{}");
  writer.finish();
  EXPECT_THAT(refusal().what(), HasSubstr("holds no tileset.json"));
}

TEST_F(Archives, WithoutAnIndexAreRefused) {
  write();
  auto text = read_file(file, most);
  text.replace(text.rfind(zip::index_name), 2, "__");
  write_file(file, text);
  EXPECT_THAT(refusal().what(), HasSubstr("is no .3tz"));
}

TEST_F(Archives, CutShortAreRefused) {
  write();
  const auto text = read_file(file, most);
  for (std::size_t length = 0; length < text.size(); length += 23) {
    write_file(file, text.substr(0, length));
    EXPECT_EQ(refusal().fault, Fault::bad_input) << length;
  }
}

TEST_F(Archives, WithCompressedFilesAreRefused) {
  write();
  damage("PK\3\4", 8, std::string_view("\x08\0", 2));  // of tileset.json
  EXPECT_THAT(refusal().what(), HasSubstr("tileset.json is compressed"));
}

TEST_F(Archives, RefuseASizeBeyondTheirEnd) {
  write();
  damage("PK\3\4", 22, "\xFF\xFF\xFF\x7F");
  EXPECT_THAT(refusal().what(), HasSubstr("damaged or cut short"));
}

TEST_F(Archives, OfATilesetHoldEveryFileOfItAsItIs) {
  shapes::World world;
  world.levels = 6;  // so that it has external tilesets
  world.strip = true;
  const Folder bake_folder("archive-bake");
  const auto bake = world.make(bake_folder.path);
  const auto files = tileset::write_index(bake, tileset::estimate_errors(bake), bake_folder.path);
  ASSERT_TRUE(fs::is_directory(bake_folder.path / "subtrees"));
  EXPECT_EQ(pack(bake_folder.path, file), files.size());
  const Archive archive(file);
  EXPECT_EQ(archive.entries(), files.size());
  for (const auto& path : files) {
    const auto part = archive.find(path.generic_string());
    ASSERT_TRUE(part.has_value()) << path;
    EXPECT_EQ(archive.read(*part), read_file(bake_folder.path / path, most)) << path;
  }
}

}  // namespace
}  // namespace hoodoo::archive
