#include "server/http/keys.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/server/temporary_folder.hpp"

namespace hoodoo::http {
namespace {

class KeysFile : public testing::Test {
 protected:
  /// What is said of a file with this text.
  std::string refusal(const std::string& text) {
    temporary.write("keys.json", text);
    try {
      Keys::read(file);
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing";
  }

  TemporaryFolder temporary;
  std::filesystem::path file = temporary.path / "keys.json";
};

TEST_F(KeysFile, KnowsItsKeysAndNoOthers) {
  const auto ci = Keys::add(file, "ci", {Scope::submit});
  const auto ops = Keys::add(file, "ops", {Scope::admin});
  EXPECT_NE(ci, ops);
  const auto keys = Keys::read(file);
  ASSERT_NE(keys.find("Bearer " + ci), nullptr);
  EXPECT_EQ(keys.find("Bearer " + ci)->name, "ci");
  EXPECT_EQ(keys.find("bEARER " + ops)->name, "ops");
  const std::vector<std::string> strangers{"",
                                           ci,
                                           "Basic " + ci,
                                           "Bearer",
                                           "Bearer ",
                                           "Bearer " + ci + "0",
                                           "Bearer  " + ci,
                                           "Bearer " + keys.find("Bearer " + ci)->digest.hex()};
  for (const auto& header : strangers) {
    EXPECT_EQ(keys.find(header), nullptr) << header;
  }
  EXPECT_TRUE(keys.find("Bearer " + ci)->may(Scope::submit));
  EXPECT_FALSE(keys.find("Bearer " + ci)->may(Scope::read));
  EXPECT_TRUE(keys.find("Bearer " + ops)->may(Scope::read));
}

TEST_F(KeysFile, HoldsNoKeyItselfAndIsItsOwnersAlone) {
  const auto text = Keys::add(file, "ci", {Scope::submit});
  EXPECT_EQ(read_file(file, 1 << 20).find(text), std::string::npos);
  struct stat state {};
  ASSERT_EQ(::stat(file.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0600U);
}

TEST_F(KeysFile, TakesANewKeyForAnOldOne) {
  const auto old = Keys::add(file, "ci", {Scope::submit});
  const auto now = Keys::add(file, "ci", {Scope::read});
  const auto keys = Keys::read(file);
  EXPECT_EQ(keys.find("Bearer " + old), nullptr);
  EXPECT_TRUE(keys.find("Bearer " + now)->may(Scope::read));
}

TEST_F(KeysFile, KeepsWhatAKeyMayUse) {
  job::Quota quota;
  quota.jobs = 3;
  quota.bytes = 1U << 20;
  quota.bake = {500, 1234.5};
  const auto small = Keys::add(file, "small", {Scope::submit}, quota);
  const auto free = Keys::add(file, "free", {Scope::submit});
  const auto keys = Keys::read(file);
  const auto& read = keys.find("Bearer " + small)->quota;
  EXPECT_EQ(read.jobs, 3U);
  EXPECT_EQ(read.bytes, 1U << 20);
  EXPECT_EQ(read.bake.tiles, 500U);
  EXPECT_EQ(read.bake.extent, 1234.5);
  EXPECT_FALSE(keys.find("Bearer " + free)->quota.jobs);
}

TEST_F(KeysFile, NamesWhatIsWrong) {
  const std::string digest(64, 'a');
  const auto one = [&](const std::string& entry) { return R"({"keys": [)" + entry + "]}"; };
  EXPECT_NE(refusal("{").find("no JSON"), std::string::npos);
  EXPECT_NE(refusal("[]").find("must be {"), std::string::npos);
  EXPECT_NE(refusal(one("")).find("#/keys"), std::string::npos);
  EXPECT_NE(refusal(one(R"({"name": "a b", "sha256": ")" + digest + R"(", "scopes": ["read"]})"))
                .find("#/keys/0/name"),
            std::string::npos);
  EXPECT_NE(refusal(one(R"({"name": "a", "sha256": "12", "scopes": ["read"]})")).find("sha256"),
            std::string::npos);
  EXPECT_NE(refusal(one(R"({"name": "a", "sha256": ")" + digest + R"(", "scopes": ["root"]})"))
                .find("#/keys/0/scopes/0"),
            std::string::npos);
  EXPECT_NE(refusal(one(R"({"name": "a", "sha256": ")" + digest + R"(", "scope": ["read"]})"))
                .find("#/keys/0/scope"),
            std::string::npos);
  for (const std::string most : {"jobs", "bytes", "tiles", "extent", "files"}) {
    EXPECT_NE(refusal(one(R"({"name": "a", "sha256": ")" + digest +
                          R"(", "scopes": ["read"], "most": {")" + most + R"(": 0}})"))
                  .find("#/keys/0/most/" + most),
              std::string::npos);
  }
  EXPECT_THROW(Keys::add(file, "../x", {Scope::read}), Error);
}

}  // namespace
}  // namespace hoodoo::http
