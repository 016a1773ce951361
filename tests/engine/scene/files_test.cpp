#include "engine/scene/files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "engine/base/file.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

namespace fs = std::filesystem;

/// inside/dem.tif, other/dem.tif, secret.tif beside them.
class FindFile : public testing::Test {
 protected:
  FindFile() {
    write_file(folder_ / "inside/dem.tif", "a");
    write_file(folder_ / "other/more.tif", "b");
    write_file(folder_ / "secret.tif", "c");
  }
  /// The file, or "missing" or "refused".
  std::string find(const std::string& name, const Sources& sources) {
    Findings findings;
    const auto file = find_file(name, "/dem", sources, findings);
    for (const auto& problem : findings.all()) {
      EXPECT_EQ(problem.where, "/dem");
      if (name[0] == '/') continue;
      EXPECT_EQ(problem.what.find(folder_.path().string()), std::string::npos) << problem.what;
    }
    EXPECT_NE(file.has_value(), findings.any());
    if (file) return file->lexically_relative(fs::canonical(folder_.path())).string();
    return findings.missing.empty() ? "refused" : "missing";
  }
  Sources fenced() const { return {folder_ / "inside", {folder_ / "inside", folder_ / "other/"}}; }

  Folder folder_;
};

TEST_F(FindFile, StartsAtTheBase) {
  EXPECT_EQ(find("dem.tif", {folder_ / "inside", {}}), "inside/dem.tif");
  EXPECT_EQ(find("../secret.tif", {folder_ / "inside", {}}), "secret.tif");
  EXPECT_EQ(find((folder_ / "secret.tif").string(), {folder_ / "inside", {}}), "secret.tif");
  EXPECT_EQ(find("none.tif", {folder_ / "inside", {}}), "missing");
}

TEST_F(FindFile, LooksInEveryRoot) {
  EXPECT_EQ(find("dem.tif", fenced()), "inside/dem.tif");
  EXPECT_EQ(find("more.tif", fenced()), "other/more.tif");
  EXPECT_EQ(find((folder_ / "other/more.tif").string(), fenced()), "other/more.tif");
  EXPECT_EQ(find("none.tif", fenced()), "missing");
}

TEST_F(FindFile, NeverLeavesTheRoots) {
  EXPECT_EQ(find("../secret.tif", fenced()), "refused");
  EXPECT_EQ(find((folder_ / "secret.tif").string(), fenced()), "refused");
  EXPECT_EQ(find("../inside-not/dem.tif", fenced()), "refused");
  EXPECT_EQ(find("/etc/passwd", fenced()), "refused");
  EXPECT_EQ(find("/etc/there is no such file", fenced()), "refused");
  EXPECT_EQ(find("../insidedem.tif", fenced()), "refused");
}

TEST_F(FindFile, FollowsLinksBeforeItDecides) {
  fs::create_symlink(folder_ / "secret.tif", folder_ / "inside/link.tif");
  fs::create_symlink("dem.tif", folder_ / "inside/good.tif");
  fs::create_directory_symlink(folder_.path(), folder_ / "inside/up");
  EXPECT_EQ(find("link.tif", fenced()), "refused");
  EXPECT_EQ(find("up/secret.tif", fenced()), "refused");
  EXPECT_EQ(find("up/none.tif", fenced()), "refused");
  EXPECT_EQ(find("good.tif", fenced()), "inside/dem.tif");
}

TEST_F(FindFile, TakesRegularFilesOnly) {
  ASSERT_EQ(::mkfifo((folder_ / "inside/pipe").c_str(), 0600), 0);
  fs::create_directory(folder_ / "inside/folder");
  EXPECT_EQ(find("pipe", fenced()), "refused");
  EXPECT_EQ(find("folder", fenced()), "refused");
  EXPECT_EQ(find(".", fenced()), "refused");
  EXPECT_EQ(find("/dev/zero", {folder_ / "inside", {}}), "refused");
}

TEST_F(FindFile, RefusesWhatIsNoName) {
  EXPECT_EQ(find("", fenced()), "refused");
  EXPECT_EQ(find(std::string("dem.tif\0.png", 12), fenced()), "refused");
  EXPECT_EQ(find(std::string(100'000, 'a'), fenced()), "refused");
  EXPECT_EQ(find(std::string(1000, 'a'), {folder_ / "inside", {}}), "missing");
}

TEST(Findings, AreNotFoundOnlyWhenNothingElseIsWrong) {
  const auto fault = [](const Findings& findings) {
    try {
      findings.report();
    } catch (const Error& error) {
      return error.fault;
    }
    return Fault::internal;
  };
  Findings findings;
  EXPECT_EQ(fault(findings), Fault::internal);
  findings.missing.push_back({"/a", "no file"});
  EXPECT_EQ(fault(findings), Fault::not_found);
  findings.problems.push_back({"/b", "wrong"});
  EXPECT_EQ(fault(findings), Fault::bad_input);
  findings = {};
  findings.limits.push_back({"/c", "too much"});
  EXPECT_EQ(fault(findings), Fault::limit);
}

}  // namespace
}  // namespace hoodoo::scene
