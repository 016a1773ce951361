#include "server/asset/incoming.hpp"

#include <gtest/gtest.h>

#include "engine/base/file.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using asset::Incoming;
using asset::RunningHash;

namespace {

class IncomingFile : public testing::Test {
 protected:
  std::string content() const { return read_file(path, 100); }

  TemporaryFolder temporary;
  std::filesystem::path path = temporary.path / "file";
  RunningHash hash;
};

TEST_F(IncomingFile, HoldsWhatWasAddedAndItsDigest) {
  Incoming file(path, hash);
  file.make_room(5);
  file.add("ab");
  file.add("cde");
  file.sync();
  EXPECT_EQ(file.size(), 5);
  EXPECT_EQ(content(), "abcde");
  EXPECT_EQ(file.digest(), sha256("abcde"));
}
TEST_F(IncomingFile, GoesOnWhereItWas) {
  Incoming(path, hash).add("abc");
  Incoming file(path, hash);
  EXPECT_EQ(file.size(), 3);
  file.add("de");
  EXPECT_EQ(file.digest(), sha256("abcde"));
}
TEST_F(IncomingFile, ReadsWhatAnEarlierProcessWrote) {
  temporary.write("file", "abc");
  Incoming file(path, hash);
  file.add("de");
  EXPECT_EQ(file.digest(), sha256("abcde"));
}
TEST_F(IncomingFile, TakesBackWhatItShallNotHold) {
  Incoming file(path, hash);
  file.add("abcxyz");
  file.cut(3);
  file.add("de");
  EXPECT_EQ(content(), "abcde");
  EXPECT_EQ(file.digest(), sha256("abcde"));
}
TEST_F(IncomingFile, OfNoBytesHasTheirDigest) {
  EXPECT_EQ(Incoming(path, hash).digest(), sha256(""));
}

}  // namespace
