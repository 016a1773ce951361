#include "server/job/child.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "engine/base/error.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using namespace std::chrono_literals;
using job::Ended;
using job::run_child;
using testing::ElementsAre;

namespace {

using Clock = std::chrono::steady_clock;

Ended shell(const std::string& script, const job::Limits& limits = {}) {
  return run_child({"/bin/sh", "-c", script}, limits, {}, {});
}

TEST(Child, TellsHowItEndedAndWhatItSaid) {
  std::vector<std::string> lines;
  const auto ended = run_child({"/bin/sh", "-c", "echo out; echo one >&2; printf two >&2; exit 7"},
                               {}, {}, [&](std::string_view line) { lines.emplace_back(line); });
  EXPECT_EQ(ended.code, 7);
  EXPECT_EQ(ended.signal, 0);
  EXPECT_EQ(ended.output, "out\n");
  EXPECT_THAT(lines, ElementsAre("one", "two"));
  EXPECT_EQ(ended.last_line, "two");
  EXPECT_FALSE(ended.stopped);
}
TEST(Child, ThatCrashesIsToldByItsSignal) {
  const auto ended = shell("kill -SEGV $$");
  EXPECT_EQ(ended.signal, SIGSEGV);
}
TEST(Child, ThatIsNoProgramIsAnError) {
  EXPECT_THROW(run_child({"/no/such/program"}, {}, {}, {}), Error);
}
TEST(Child, HasNoInputAndNoDescriptorsOfItsParent) {
  const TemporaryFolder folder;
  const std::ifstream held(folder.write("held", "secret"));
  EXPECT_EQ(shell("wc -c").output, "0\n");
  const auto open = shell("for f in /proc/$$/fd/*; do readlink $f; done").output;
  EXPECT_EQ(open.find(folder.path), open.npos) << open;
}
TEST(Child, StopsWhenItIsAskedTo) {
  std::stop_source stop;
  const auto ended = run_child(
      {"/bin/sh", "-c", "trap 'exit 3' TERM; echo ready >&2; while :; do sleep 0.01; done"}, {},
      stop.get_token(), [&](std::string_view) { stop.request_stop(); });
  EXPECT_TRUE(ended.stopped);
  EXPECT_EQ(ended.code, 3);
}
TEST(Child, IsKilledWhenItDoesNotStop) {
  std::stop_source stop;
  auto start = Clock::now();
  const auto ended = run_child(
      {"/bin/sh", "-c", "trap '' TERM; sleep 60 & echo ready >&2; while :; do sleep 0.01; done"},
      {}, stop.get_token(), [&](std::string_view) {
        start = Clock::now();
        stop.request_stop();
      });
  EXPECT_EQ(ended.signal, SIGKILL);
  EXPECT_GE(Clock::now() - start, job::stop_patience);
  EXPECT_LT(Clock::now() - start, 10s) << "with all that it started";
}
TEST(Child, HasALimitOnProcessorTime) {
  job::Limits limits;
  limits.processor = 1s;
  const auto ended = shell("while :; do :; done", limits);
  EXPECT_EQ(ended.signal, SIGXCPU);
}
TEST(Child, HasALimitOnMemory) {
  job::Limits limits;
  limits.memory = 32u << 20;
  const std::string doubling = "x=aaaaaaaa; i=0; while [ $i -lt 26 ]; do x=$x$x; i=$((i+1)); done";
  const auto ended = shell(doubling + "; echo done", limits);
  EXPECT_EQ(ended.output, "") << "512 MiB";
  EXPECT_NE(ended.code + ended.signal, 0);
}
TEST(Child, DiesWithTheThreadThatWaitsForIt) {
  // What kills the server takes its children along, so that none goes on writing unseen.
  const TemporaryFolder folder;
  const auto parent = ::fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    shell("echo $$ > " + (folder.path / "pid").string() + "; sleep 60; sleep 60");
    ::_exit(0);
  }
  int child = 0;
  for (int i = 0; i < 5000 && child == 0; ++i) {
    std::this_thread::sleep_for(1ms);
    std::ifstream(folder.path / "pid") >> child;
  }
  ASSERT_GT(child, 0);
  ::kill(parent, SIGKILL);
  bool alive = true;
  for (int i = 0; i < 5000 && alive; ++i) {
    std::this_thread::sleep_for(1ms);
    // Its state, behind the name in parentheses: Z is dead, and waits for somebody to ask.
    std::string line;
    std::getline(std::ifstream("/proc/" + std::to_string(child) + "/stat"), line);
    const auto name_end = line.rfind(')');
    alive = name_end != line.npos && line.at(name_end + 2) != 'Z';
  }
  EXPECT_FALSE(alive);
}

}  // namespace
