#include "engine/base/file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"

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

TEST_F(Folder, SeesAFileWrittenPieceByPieceOnceItIsCommitted) {
  const auto path = folder / "file";
  write_file(path, "old");
  FileWriter writer(path);
  writer.write("count 0;");
  const std::string large(3 << 20, 'x');  // more than waits in memory
  writer.write(large);
  writer.put(std::uint16_t{0x4241});
  EXPECT_EQ(writer.position(), 8 + large.size() + 2);
  writer.seek(6);
  writer.write("7");
  EXPECT_EQ(read_file(path, 10), "old");
  writer.commit();
  EXPECT_EQ(read_file(path, 4 << 20), "count 7;" + large + "AB");
}

TEST_F(Folder, KeepsNothingOfAFileThatIsNotCommitted) {
  {
    FileWriter writer(folder / "file");
    writer.write("half");
    EXPECT_TRUE(is_leftover(writer.temporary()));
    EXPECT_TRUE(std::filesystem::exists(writer.temporary()));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace hoodoo
