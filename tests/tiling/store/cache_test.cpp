#include "tiling/store/cache.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <thread>

#include "engine/base/file.hpp"

namespace hoodoo::store {
namespace {

namespace fs = std::filesystem;

class CacheTest : public testing::Test {
 protected:
  ~CacheTest() override { fs::remove_all(folder_); }

  static std::vector<std::byte> bytes(std::string_view text) {
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
  }
  /// The only entry's file.
  fs::path file() const {
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      if (entry.is_regular_file()) return entry.path();
    }
    return {};
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("hoodoo-cache-" + std::to_string(::getpid()));
  const Digest slice_ = sha256("a slice");
};

TEST_F(CacheTest, GivesBackWhatWasPut) {
  Cache cache(folder_);
  EXPECT_FALSE(cache.has(slice_));
  EXPECT_FALSE(cache.get(slice_));
  const auto tile = bytes(std::string_view("glTF\0\n\xff", 7));
  cache.put(slice_, "{\"key\": 1}", tile);
  EXPECT_TRUE(cache.has(slice_));
  const auto entry = Cache(folder_).get(slice_);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->record, "{\"key\": 1}");
  EXPECT_EQ(entry->tile, tile);
  EXPECT_FALSE(cache.get(sha256("another slice")));
  EXPECT_EQ(cache.warning(), "");
}

TEST_F(CacheTest, HoldsTilesWithoutASurface) {
  Cache cache(folder_);
  cache.put(slice_, "{}", {});
  const auto entry = cache.get(slice_);
  ASSERT_TRUE(entry);
  EXPECT_TRUE(entry->tile.empty());
}

TEST_F(CacheTest, MissesAnEntryWithAnyByteFlippedOrCutOff) {
  Cache cache(folder_);
  cache.put(slice_, "{}", bytes("tile"));
  const auto good = read_file(file(), 1 << 20);
  for (std::size_t i = 0; i < good.size(); ++i) {
    auto damaged = good;
    damaged[i] = static_cast<char>(damaged[i] ^ 4);
    write_file(file(), damaged);
    EXPECT_FALSE(cache.get(slice_)) << "byte " << i;
    write_file(file(), good.substr(0, i));
    EXPECT_FALSE(cache.get(slice_)) << "length " << i;
  }
  cache.put(slice_, "{}", bytes("tile"));
  EXPECT_EQ(read_file(file(), 1 << 20), good) << "replaced";
  EXPECT_TRUE(cache.get(slice_));
}

TEST_F(CacheTest, WarnsOnceWhenItCannotBeWritten) {
  write_file(folder_ / "file", "in the way");
  Cache cache(folder_ / "file");
  cache.put(slice_, "{}", bytes("tile"));
  EXPECT_NE(cache.warning().find("the cache is not written"), std::string::npos);
  EXPECT_FALSE(cache.get(slice_));
}

TEST_F(CacheTest, MayBeWrittenByManyAtOnce) {
  const auto tile = bytes(std::string(100'000, 'x'));
  {
    std::vector<std::jthread> writers;
    for (int i = 0; i < 8; ++i) {
      writers.emplace_back([&] {
        Cache cache(folder_);
        for (int k = 0; k < 5; ++k) {
          cache.put(slice_, "{}", tile);
          const auto entry = cache.get(slice_);
          EXPECT_TRUE(entry && entry->tile == tile);
        }
        EXPECT_EQ(cache.warning(), "");
      });
    }
  }
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(folder_), {}), 2) << "no leftovers";
}

}  // namespace
}  // namespace hoodoo::store
