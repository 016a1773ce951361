#include "server/job/state.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

using namespace hoodoo;
using job::Status;

namespace {

TEST(JobState, ComesBackAsItWas) {
  job::Job job;
  job.status = Status::failed;
  job.fault = Fault::limit;
  job.problems = {{"/terrains/0", "is \"too\" large, caf\xc3\xa9"}};
  job.outcome.warnings = {"a name is long"};
  job.outcome.progress.phase = bake::Progress::Phase::tiles;
  job.outcome.progress.done = 3;
  job.outcome.progress.bytes = std::uint64_t{1} << 33;
  job::Job back;
  back.status = Status::failed;
  job::read_text(job::to_text(job), back);
  EXPECT_EQ(back.fault, job.fault);
  EXPECT_EQ(back.problems.at(0).what, job.problems[0].what);
  EXPECT_EQ(back.outcome.warnings, job.outcome.warnings);
  EXPECT_EQ(back.outcome.progress.phase, job.outcome.progress.phase);
  EXPECT_EQ(back.outcome.progress.bytes, job.outcome.progress.bytes);
}
TEST(JobState, ThatIsDamagedMakesAFailedJob) {
  for (const auto* text : {"", "{", "[]", "{\"warnings\": 3}", "{\"progress\": {}}"}) {
    job::Job job;
    job::read_text(text, job);
    EXPECT_EQ(job.status, Status::failed) << text;
    EXPECT_FALSE(job.problems.empty()) << text;
  }
}
TEST(JobState, KnowsItsWords) {
  EXPECT_EQ(job::status_of(job::name_of(Status::dismissed)), Status::dismissed);
  EXPECT_EQ(job::fault_of(job::name_of(Fault::io)), Fault::io);
  EXPECT_THROW(job::status_of("frozen"), Error);
}
TEST(JobId, IsThirtyTwoLowerCaseHexadecimalDigits) {
  EXPECT_TRUE(job::is_id("0123456789abcdef0123456789abcdef"));
  EXPECT_FALSE(job::is_id("0123456789ABCDEF0123456789abcdef"));
  EXPECT_FALSE(job::is_id("../56789abcdef0123456789abcdef01"));
  EXPECT_FALSE(job::is_id(""));
}

}  // namespace
