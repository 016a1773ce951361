#include "engine/base/lock.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <vector>

#include "engine/base/error.hpp"

namespace hoodoo {
namespace {

namespace fs = std::filesystem;
using Kind = FileLock::Kind;

class Lock : public testing::Test {
 protected:
  ~Lock() override { fs::remove_all(folder_); }
  const fs::path folder_ =
      fs::temp_directory_path() / ("hoodoo-lock-" + std::to_string(::getpid()));
  const fs::path file_ = folder_ / "below" / "a.lock";
};

TEST_F(Lock, IsHeldByOneAtATime) {
  std::atomic<int> inside = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      const FileLock lock(file_, Kind::exclusive, {});
      EXPECT_EQ(++inside, 1);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      --inside;
    });
  }
}

TEST_F(Lock, SharedBecomesExclusiveForTheLastAlone) {
  auto first = std::make_unique<FileLock>(file_, Kind::shared, std::stop_token());
  FileLock second(file_, Kind::shared, {});
  EXPECT_FALSE(first->make_exclusive());
  first.reset();
  EXPECT_TRUE(second.make_exclusive());
}

TEST_F(Lock, StopsWaitingWhenAsked) {
  const FileLock held(file_, Kind::shared, {});
  std::stop_source stop;
  stop.request_stop();
  try {
    const FileLock waiting(file_, Kind::exclusive, stop.get_token());
    FAIL() << "two hold it";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::cancelled);
  }
}

TEST_F(Lock, SaysWhereItCannotBe) {
  try {
    const FileLock lock("/proc/no/such.lock", Kind::shared, {});
    FAIL() << "locked";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::io);
    EXPECT_EQ(error.problems.at(0).where, "/proc/no/such.lock");
  }
}

}  // namespace
}  // namespace hoodoo
