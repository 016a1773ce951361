#include "tiling/store/store.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

namespace hoodoo::store {
namespace {

namespace fs = std::filesystem;

class Store : public testing::Test {
 protected:
  Store() { fs::create_directories(folder_); }
  ~Store() override { fs::remove_all(folder_); }

  static std::vector<std::byte> bytes(std::string_view text) {
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
  }
  Fault fault_of(const Digest& content) const {
    try {
      get_tile(folder_, content);
    } catch (const Error& error) {
      return error.fault;
    }
    return Fault::internal;
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("hoodoo-store-" + std::to_string(::getpid()));
};

TEST_F(Store, NamesTilesByTheirContent) {
  const auto content = put_tile(folder_, bytes("abc"));
  EXPECT_EQ(tile_path(content).string(),
            "tiles/ba/ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad.glb");
  EXPECT_EQ(read_file(folder_ / tile_path(content), 100), "abc");
  EXPECT_EQ(get_tile(folder_, content), bytes("abc"));
}

TEST_F(Store, DoesNotWriteWhatIsThere) {
  const auto content = put_tile(folder_, bytes("abc"));
  const auto file = folder_ / tile_path(content);
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(5);
  fs::last_write_time(file, old);
  put_tile(folder_, bytes("abc"));
  EXPECT_EQ(fs::last_write_time(file), old);
}

TEST_F(Store, MendsADamagedFile) {
  const auto content = put_tile(folder_, bytes("abc"));
  std::ofstream(folder_ / tile_path(content)) << "abd";
  EXPECT_EQ(fault_of(content), Fault::bad_input);
  put_tile(folder_, bytes("abc"));
  EXPECT_EQ(get_tile(folder_, content), bytes("abc"));
}

TEST_F(Store, SaysWhenATileIsMissing) { EXPECT_EQ(fault_of(sha256("nothing")), Fault::not_found); }

TEST_F(Store, SweepsWhatIsNotKeptAndLeftovers) {
  const auto kept = tile_path(put_tile(folder_, bytes("kept")));
  const auto dropped = tile_path(put_tile(folder_, bytes("dropped")));
  std::ofstream(folder_ / "tileset.json.12-1.part") << "half";
  std::ofstream(folder_ / (kept.string() + ".12-2.part")) << "half";
  std::ofstream(folder_ / "notes.txt") << "not ours";
  sweep(folder_, [&](const fs::path& file) { return file == kept; });
  EXPECT_TRUE(fs::exists(folder_ / kept));
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
  EXPECT_FALSE(fs::exists(folder_ / dropped.parent_path()));
  EXPECT_FALSE(fs::exists(folder_ / "tileset.json.12-1.part"));
  EXPECT_FALSE(fs::exists(folder_ / (kept.string() + ".12-2.part")));
}

TEST_F(Store, SweepsElevationsByTheFolderTheyAreIn) {
  const auto elevations = fs::path(".hoodoo") / "elevations";
  for (const char* name : {"kept/pyramid.json", "old/pyramid.json", "killed.part/level_0.f32"}) {
    write_file(folder_ / elevations / name, "text");
  }
  write_file(folder_ / elevations / "old.lock", "");
  sweep(folder_, [&](const fs::path& file) { return file.parent_path() == elevations / "kept"; });
  EXPECT_TRUE(fs::exists(folder_ / elevations / "kept" / "pyramid.json"));
  for (const char* name : {"old", "old.lock", "killed.part"}) {
    EXPECT_FALSE(fs::exists(folder_ / elevations / name)) << name;
  }
}

TEST_F(Store, NamesTilesByTheirDigest) {
  EXPECT_EQ(digest_of(tile_path(sha256("abc"))), sha256("abc"));
  EXPECT_EQ(digest_of("tiles/ab/notes.glb"), std::nullopt);
}

TEST_F(Store, SweepsAFolderWithoutTiles) {
  EXPECT_NO_THROW(sweep(folder_ / "none", [](const fs::path&) { return false; }));
}

}  // namespace
}  // namespace hoodoo::store
