#include "server/asset/assets.hpp"

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using asset::Assets;
using asset::Draft;

namespace {

Fault fault_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.fault;
  }
  return Fault::internal;
}
std::size_t count(const std::filesystem::path& folder) {
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& item : std::filesystem::directory_iterator(folder)) ++files;
  return files;
}

class AssetFolder : public testing::Test {
 protected:
  void put(const std::string& bytes, const Digest& digest) {
    Draft draft(assets, bytes.size());
    draft.add(bytes);
    draft.commit(digest);
  }

  TemporaryFolder temporary;
  Assets assets{temporary.path, 100};
};

TEST(AssetName, IsOfOneFormOnly) {
  const auto digest = sha256("abc");
  const auto name = asset::name_of(digest);
  EXPECT_EQ(asset::digest_of(name), digest);
  for (const auto& wrong : {name + "0", name.substr(1), digest.hex(), std::string(), name + "/",
                            "sha256-" + std::string(64, 'G'), "SHA256-" + digest.hex()}) {
    EXPECT_EQ(asset::digest_of(wrong), std::nullopt) << wrong;
  }
}
TEST_F(AssetFolder, HoldsWhatWasPut) {
  const auto digest = sha256("abc");
  EXPECT_FALSE(assets.holds(digest));
  put("abc", digest);
  EXPECT_TRUE(assets.holds(digest));
  EXPECT_EQ(read_file(assets.file(digest), 10), "abc");
  EXPECT_EQ(count(assets.under_way()), 0);
}
TEST_F(AssetFolder, KeepsNothingOfAnotherDigest) {
  EXPECT_EQ(fault_of([&] { put("abc", sha256("x")); }), Fault::bad_input);
  EXPECT_FALSE(assets.holds(sha256("x")));
  EXPECT_EQ(count(assets.under_way()), 0);
}
TEST_F(AssetFolder, GivesNoMoreSpaceThanThereIs) {
  EXPECT_EQ(fault_of([&] { assets.reserve(101); }), Fault::limit);
  put(std::string(40, 'a'), sha256(std::string(40, 'a')));
  auto held = assets.reserve(50);
  EXPECT_EQ(fault_of([&] { assets.reserve(11); }), Fault::io);
  EXPECT_NE(assets.reserve(10), nullptr);
  held.reset();
  EXPECT_NE(assets.reserve(60), nullptr);
  std::filesystem::remove(assets.file(sha256(std::string(40, 'a'))));
  EXPECT_NE(assets.reserve(100), nullptr) << "what was removed by hand leaves its space";
}
TEST_F(AssetFolder, ListsAndRemoves) {
  const auto digest = sha256("abc");
  put("abc", digest);
  temporary.write("assets/notes.txt", "no asset");
  ASSERT_EQ(assets.list().size(), 1U);
  EXPECT_EQ(assets.list().front(), asset::name_of(digest));
  assets.remove(digest);
  EXPECT_FALSE(assets.holds(digest));
  assets.remove(digest);  // it may be gone by then
}
TEST_F(AssetFolder, LeavesTheDiskSomeRoom) {
  const auto left = asset::left_on_disk(temporary.path);
  ASSERT_GT(left, 100U << 20);
  Assets careful(temporary.path, 100, left + (std::uint64_t{1} << 40));
  EXPECT_EQ(fault_of([&] { careful.reserve(1); }), Fault::io);
}
TEST_F(AssetFolder, RemovesWhatAKilledServerLeft) {
  temporary.write("uploads/a.part", "abc");
  temporary.write("uploads/b.data", "abc");
  const Assets again(temporary.path, 100);
  EXPECT_EQ(count(assets.under_way()), 1) << "an upload may go on";
}

}  // namespace
