#include "server/job/state.hpp"

#include <gtest/gtest.h>

using namespace hoodoo;
using job::Status;

namespace {

job::Job failed_job() {
  job::Job job;
  job.id = "0123456789abcdef0123456789abcdef";
  job.serial = 7;
  job.status = Status::failed;
  job.name = "caf\xc3\xa9 \"quoted\"";
  job.created = job::Time(std::chrono::milliseconds(1'700'000'000'123));
  job.updated = job.created + std::chrono::seconds(5);
  job.started = job.created;
  job.fault = Fault::limit;
  job.problems = {{"/terrains/0", "is too large"}};
  job.warnings = {"a name is long"};
  job.progress.done = 3;
  job.progress.bytes = 1U << 31;
  return job;
}

TEST(JobState, ComesBackAsItWas) {
  const auto job = failed_job();
  const auto back = job::from_text(job.id, job::to_text(job));
  EXPECT_EQ(back.serial, job.serial);
  EXPECT_EQ(back.status, job.status);
  EXPECT_EQ(back.name, job.name);
  EXPECT_EQ(back.created, job.created);
  EXPECT_EQ(back.started, job.started);
  EXPECT_EQ(back.finished, std::nullopt);
  EXPECT_EQ(back.fault, job.fault);
  EXPECT_EQ(back.problems.at(0).what, job.problems[0].what);
  EXPECT_EQ(back.warnings, job.warnings);
  EXPECT_EQ(back.progress.bytes, job.progress.bytes);
}
TEST(JobState, OfARunningJobMeansItContinues) {
  auto job = failed_job();
  job.status = Status::running;
  EXPECT_EQ(job::from_text(job.id, job::to_text(job)).status, Status::accepted);
}
TEST(JobState, ThatIsDamagedMakesAFailedJob) {
  for (const auto* text : {"", "{", "[]", "{\"status\": \"frozen\"}", "{\"status\": 3}"}) {
    const auto job = job::from_text("0123456789abcdef0123456789abcdef", text);
    EXPECT_EQ(job.status, Status::failed) << text;
    EXPECT_FALSE(job.problems.empty()) << text;
  }
}
TEST(JobId, IsThirtyTwoLowerCaseHexadecimalDigits) {
  EXPECT_TRUE(job::is_id("0123456789abcdef0123456789abcdef"));
  EXPECT_FALSE(job::is_id("0123456789ABCDEF0123456789abcdef"));
  EXPECT_FALSE(job::is_id("../56789abcdef0123456789abcdef01"));
  EXPECT_FALSE(job::is_id(""));
}

}  // namespace
