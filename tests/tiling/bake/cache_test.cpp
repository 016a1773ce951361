// Bakes that share finished tiles.
#include <gtest/gtest.h>

#include "tests/tiling/bake/folder.hpp"

using namespace hoodoo;
namespace fs = std::filesystem;

namespace {

class SharedCache : public BakeTest {
 protected:
  bake::Report cached(const std::string& name, const nlohmann::json& what = scene()) {
    bake::Settings settings;
    settings.cache = folder_ / "cache";
    return run(what, name, settings);
  }
  std::vector<fs::path> entries() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache")) {
      if (entry.is_regular_file()) found.push_back(entry.path());
    }
    return found;
  }
};

}  // namespace

TEST_F(SharedCache, SparesASecondBakeAllTiles) {
  run(scene(), "alone");
  const auto first = cached("first");
  EXPECT_EQ(first.progress.cached, 0U);
  EXPECT_EQ(entries().size(), first.progress.done);
  const auto second = cached("second");
  EXPECT_EQ(second.progress.cached, second.progress.done);
  EXPECT_EQ(second.progress.reused, 0U);
  EXPECT_TRUE(second.complete);
  EXPECT_EQ(files("first"), files("alone"));
  EXPECT_EQ(files("second"), files("alone"));
}

TEST_F(SharedCache, SparesAnEditTheTilesOutOfItsReach) {
  cached("before", scene(300));
  const auto after = cached("after", scene(310));
  EXPECT_GT(after.progress.cached, 4U);
  EXPECT_LT(after.progress.cached, after.progress.done);
  run(scene(310), "clean");
  EXPECT_EQ(files("after"), files("clean"));
}

TEST_F(SharedCache, ReplacesDamagedEntries) {
  cached("first");
  const auto whole = files("cache");
  int flipped = 0;
  for (const auto& entry : entries()) {
    auto bytes = read_file(entry, 1U << 30);
    const auto at = bytes.size() * static_cast<std::size_t>(++flipped) / (entries().size() + 1);
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_file(entry, bytes);
  }
  const auto second = cached("second");
  EXPECT_EQ(second.progress.cached, 0U);
  EXPECT_EQ(files("second"), files("first"));
  EXPECT_EQ(files("cache"), whole);
}

TEST_F(SharedCache, DoesNotTrustAnEntryOfAnotherSlice) {
  cached("first");
  const auto found = entries();
  ASSERT_GT(found.size(), 1U);
  write_file(found[0], read_file(found[1], 1U << 30));
  const auto second = cached("second");
  EXPECT_EQ(second.progress.cached, second.progress.done - 1);
  EXPECT_EQ(files("second"), files("first"));
}

TEST_F(SharedCache, ThatCannotBeWrittenIsAWarning) {
  write_file(folder_ / "cache", "a file is in the way");
  const auto report = cached("out");
  EXPECT_TRUE(report.complete);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_NE(report.warnings.back().find("the cache is not written"), std::string::npos);
  run(scene(), "alone");
  EXPECT_EQ(files("out"), files("alone"));
}
