#include "engine/base/file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "engine/base/error.hpp"

namespace hoodoo {
namespace {

class Folder : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "hoodoo-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  Fault fault_of_reading(const std::filesystem::path& path, std::uintmax_t most) {
    try {
      read_file(path, most);
    } catch (const Error& e) {
      EXPECT_EQ(e.problems.at(0).where, path.string());
      return e.fault;
    }
    ADD_FAILURE() << "read " << path;
    return Fault::internal;
  }

  std::filesystem::path folder;
};

TEST_F(Folder, GivesBackWhatWasWritten) {
  const std::string text("a\0b\n", 4);
  write_file(folder / "deep" / "er" / "file", text);
  EXPECT_EQ(read_file(folder / "deep" / "er" / "file", 4), text);
  write_file(folder / "deep" / "er" / "file", "");
  EXPECT_EQ(read_file(folder / "deep" / "er" / "file", 0), "");
}

TEST_F(Folder, HoldsNothingBesideAFinishedFile) {
  write_file(folder / "file", "old");
  write_file(folder / "file", "new");
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    EXPECT_FALSE(is_leftover(entry.path()));
    ++files;
  }
  EXPECT_EQ(files, 1u);
  EXPECT_EQ(read_file(folder / "file", 3), "new");
}

TEST_F(Folder, NamesTheFileAndTheFault) {
  write_file(folder / "file", "four");
  EXPECT_EQ(fault_of_reading(folder / "absent", 10), Fault::not_found);
  EXPECT_EQ(fault_of_reading(folder / "file", 3), Fault::limit);
  EXPECT_EQ(fault_of_reading(folder, 10), Fault::bad_input);
}

TEST_F(Folder, KeepsTheOldFileWhereTheNewOneCannotBeWritten) {
  write_file(folder / "file", "old");
  EXPECT_THROW(write_file(folder / "file" / "below", "new"), Error);
  EXPECT_EQ(read_file(folder / "file", 3), "old");
}

TEST(IsLeftover, KnowsTheTemporariesOfAKilledProcess) {
  EXPECT_TRUE(is_leftover("a/tile.glb.123-4.part"));
  EXPECT_FALSE(is_leftover("a/tile.glb"));
}

}  // namespace
}  // namespace hoodoo
