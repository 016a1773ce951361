#include "server/asset/uploads.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <thread>
#include <variant>

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
  asset::Upload create(std::uint64_t length, const std::optional<Digest>& wanted,
                       const std::string& owner) {
    return std::get<asset::Upload>(uploads->create(length, wanted, owner));
  }
  /// As an earlier process would have left so many.
  void leave(std::size_t count, const std::function<void(const std::string& id)>& write) {
    for (std::size_t n = 0; n < count; ++n) write(std::to_string(n));
    restart();
  }
  std::size_t states() const {
    std::size_t files = 0;
    for (const auto& item : std::filesystem::directory_iterator(assets.under_way())) {
      if (item.path().extension() == ".json") ++files;
    }
    return files;
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
  const auto upload = create(5, sha256("abcde"), "artist");
  add(upload.id, "abc");
  EXPECT_EQ(uploads->find(upload.id)->offset, 3);
  EXPECT_EQ(uploads->find(upload.id)->made, std::nullopt);
  add(upload.id, "de");
  EXPECT_EQ(uploads->find(upload.id)->offset, 5);
  EXPECT_EQ(uploads->find(upload.id)->made, sha256("abcde"));
  EXPECT_EQ(read_file(assets.file(sha256("abcde")), 10), "abcde");
  EXPECT_EQ(uploads->take(upload.id), nullptr) << "it is finished";
}
TEST_F(UploadFolder, GoesOnInTheNextProcess) {
  const auto upload = create(5, {}, "artist");
  add(upload.id, "abc");
  restart();
  const auto found = uploads->find(upload.id);
  EXPECT_EQ(found->offset, 3);
  EXPECT_EQ(found->owner, "artist");
  add(upload.id, "de");
  restart();
  EXPECT_EQ(uploads->find(upload.id)->made, sha256("abcde")) << "and is remembered";
}
TEST_F(UploadFolder, HasOneHolderAtATime) {
  const auto upload = create(5, {}, "");
  auto turn = uploads->take(upload.id);
  EXPECT_EQ(uploads->take(upload.id), nullptr);
  EXPECT_FALSE(uploads->remove(upload.id));
  turn.reset();
  EXPECT_NE(uploads->take(upload.id), nullptr);
  EXPECT_TRUE(uploads->remove(upload.id));
  EXPECT_EQ(uploads->find(upload.id), std::nullopt);
}
TEST_F(UploadFolder, IsGoneWhenItsDigestIsAnother) {
  const auto upload = create(3, sha256("x"), "");
  {
    const auto turn = uploads->take(upload.id);
    turn->add("abc");
    EXPECT_THROW(turn->end(), Error);
  }
  EXPECT_EQ(uploads->find(upload.id), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_empty(assets.under_way()));
  EXPECT_NE(assets.reserve(100), nullptr) << "its space, too";
}
TEST_F(UploadFolder, KeepsItsSpace) {
  const auto upload = create(60, {}, "");
  EXPECT_THROW(assets.reserve(41), Error);
  restart();
  EXPECT_THROW(assets.reserve(41), Error);
  uploads->remove(upload.id);
  EXPECT_NE(assets.reserve(100), nullptr);
}
TEST_F(UploadFolder, ForgetsWhatNothingIsAddedTo) {
  restart(std::chrono::seconds(1));
  const auto upload = create(3, {}, "");
  std::this_thread::sleep_for(std::chrono::milliseconds(3500));
  EXPECT_EQ(uploads->find(upload.id), std::nullopt);
  EXPECT_TRUE(std::filesystem::is_empty(assets.under_way()));
}
TEST_F(UploadFolder, SurvivesDamagedStates) {
  const auto upload = create(3, {}, "");
  temporary.write("uploads/0123.json", "{\"length\": -1");
  temporary.write("uploads/4567.json", "[]");
  temporary.write("uploads/89ab.data", "abc");
  restart();
  EXPECT_TRUE(uploads->find(upload.id).has_value());
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& item :
       std::filesystem::directory_iterator(assets.under_way())) {
    ++files;
  }
  EXPECT_EQ(files, 2) << "only the whole one is left";
}
TEST_F(UploadFolder, WasKilledBeforeItCouldSayThatItIsAnAsset) {
  const auto upload = create(3, sha256("abc"), "");
  uploads.reset();
  assets.adopt(temporary.write("uploads/" + upload.id + ".data", "abc"), sha256("abc"));
  restart();
  EXPECT_EQ(uploads->find(upload.id)->made, sha256("abc"));
}
TEST_F(UploadFolder, CountsOnlyThoseThatAreUnderWay) {
  const auto made = sha256("").hex();
  leave(Uploads::most, [&](const std::string& id) {
    temporary.write("uploads/" + id + ".json",
                    R"({"length": 0, "owner": "", "made": ")" + made + "\"}");
  });
  const auto upload = create(0, {}, "");
  uploads->take(upload.id)->end();
  EXPECT_TRUE(uploads->find(upload.id)->made);
  EXPECT_EQ(states(), Uploads::most) << "the oldest is forgotten";
}
TEST_F(UploadFolder, TakesSoManyOfAll) {
  leave(Uploads::most, [&](const std::string& id) {
    temporary.write("uploads/" + id + ".json", R"({"length": 0, "owner": ""})");
    temporary.write("uploads/" + id + ".data", "");
  });
  EXPECT_EQ(std::get<Uploads::Full>(uploads->create(0, {}, "")), Uploads::Full::all);
}
TEST_F(UploadFolder, TakesSoManyOfOneOwner) {
  std::string last;
  for (std::size_t n = 0; n < Uploads::most_of_owner; ++n) last = create(0, {}, "artist").id;
  EXPECT_EQ(std::get<Uploads::Full>(uploads->create(0, {}, "artist")), Uploads::Full::owner);
  create(0, {}, "other");
  uploads->take(last)->end();
  create(0, {}, "artist");
}

}  // namespace
