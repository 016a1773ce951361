#include "server/asset/uploads.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using asset::Assets;
using asset::Uploads;

namespace {

constexpr std::chrono::seconds patience{60};

class UploadFolder : public testing::Test {
 protected:
  void restart(std::chrono::seconds kept = patience) {
    uploads.reset();
    uploads = std::make_unique<Uploads>(assets, kept);
  }
  void add(const std::string& id, std::string_view bytes) {
    const auto turn = uploads->take(id);
    ASSERT_NE(turn, nullptr);
    turn->add(bytes);
    turn->end();
  }

  TemporaryFolder temporary;
  Assets assets{temporary.path, 100};
  std::unique_ptr<Uploads> uploads = std::make_unique<Uploads>(assets, patience);
};

TEST_F(UploadFolder, MakesAnAssetOfItsParts) {
  const auto upload = uploads->create(5, sha256("abcde"), "artist");
  add(upload->id, "abc");
  EXPECT_EQ(uploads->find(upload->id)->offset, 3);
  EXPECT_EQ(uploads->find(upload->id)->made, std::nullopt);
  add(upload->id, "de");
  EXPECT_EQ(uploads->find(upload->id)->offset, 5);
  EXPECT_EQ(uploads->find(upload->id)->made, sha256("abcde"));
  EXPECT_EQ(read_file(assets.file(sha256("abcde")), 10), "abcde");
  EXPECT_EQ(uploads->take(upload->id), nullptr) << "it is finished";
}
TEST_F(UploadFolder, GoesOnInTheNextProcess) {
  const auto upload = uploads->create(5, {}, "artist");
  add(upload->id, "abc");
  restart();
  const auto found = uploads->find(upload->id);
  EXPECT_EQ(found->offset, 3);
  EXPECT_EQ(found->owner, "artist");
  add(upload->id, "de");
  restart();
  EXPECT_EQ(uploads->find(upload->id)->made, sha256("abcde")) << "and is remembered";
}
TEST_F(UploadFolder, HasOneHolderAtATime) {
  const auto upload = uploads->create(5, {}, "");
  auto turn = uploads->take(upload->id);
  EXPECT_EQ(uploads->take(upload->id), nullptr);
  EXPECT_FALSE(uploads->remove(upload->id));
  turn.reset();
  EXPECT_NE(uploads->take(upload->id), nullptr);
  EXPECT_TRUE(uploads->remove(upload->id));
  EXPECT_EQ(uploads->find(upload->id), std::nullopt);
}
TEST_F(UploadFolder, IsGoneWhenItsDigestIsAnother) {
  const auto upload = uploads->create(3, sha256("x"), "");
  {
    const auto turn = uploads->take(upload->id);
    turn->add("abc");
    EXPECT_THROW(turn->end(), Error);
  }
  EXPECT_EQ(uploads->find(upload->id), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_empty(assets.under_way()));
  EXPECT_NE(assets.reserve(100), nullptr) << "its space, too";
}
TEST_F(UploadFolder, KeepsItsSpace) {
  const auto upload = uploads->create(60, {}, "");
  EXPECT_THROW(assets.reserve(41), Error);
  restart();
  EXPECT_THROW(assets.reserve(41), Error);
  uploads->remove(upload->id);
  EXPECT_NE(assets.reserve(100), nullptr);
}
TEST_F(UploadFolder, ForgetsWhatNothingIsAddedTo) {
  restart(std::chrono::seconds(1));
  const auto upload = uploads->create(3, {}, "");
  std::this_thread::sleep_for(std::chrono::milliseconds(3500));
  EXPECT_EQ(uploads->find(upload->id), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_empty(assets.under_way()));
}
TEST_F(UploadFolder, SurvivesDamagedStates) {
  const auto upload = uploads->create(3, {}, "");
  temporary.write("uploads/0123.json", "{\"length\": -1");
  temporary.write("uploads/4567.json", "[]");
  temporary.write("uploads/89ab.data", "abc");
  restart();
  EXPECT_TRUE(uploads->find(upload->id).has_value());
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& item :
       std::filesystem::directory_iterator(assets.under_way())) {
    ++files;
  }
  EXPECT_EQ(files, 2) << "only the whole one is left";
}
TEST_F(UploadFolder, WasKilledBeforeItCouldSayThatItIsAnAsset) {
  const auto upload = uploads->create(3, sha256("abc"), "");
  uploads.reset();
  assets.adopt(temporary.write("uploads/" + upload->id + ".data", "abc"), sha256("abc"));
  restart();
  EXPECT_EQ(uploads->find(upload->id)->made, sha256("abc"));
}

}  // namespace
