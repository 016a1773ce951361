#include "server/job/state.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/job/pace.hpp"

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
  job.outputs = {"report"};
  job.outcome.progress.bytes = std::uint64_t{1} << 33;
  job::Job back;
  back.status = Status::failed;
  job::read_text(job::to_text(job), back);
  EXPECT_EQ(back.fault, job.fault);
  EXPECT_EQ(back.outputs, job.outputs);
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
TEST(Pace, TellsWhatIsLeftFromTheLastMinute) {
  job::Pace pace;
  bake::Progress progress;
  const auto left = [&](std::int64_t second, std::uint64_t done) {
    progress.done = done;
    return pace.seconds_left(job::Time(std::chrono::seconds(second)), progress);
  };
  EXPECT_EQ(left(0, 0), std::nullopt) << "elevations are read";
  progress.phase = bake::Progress::Phase::tiles;
  progress.total = 1000;
  EXPECT_EQ(left(100, 500), std::nullopt) << "those were there before";
  EXPECT_EQ(left(101, 501), std::nullopt);
  EXPECT_EQ(left(102, 504), 248U) << "two in a second";
  for (std::int64_t second = 103; second < 200; ++second) {
    left(second, 504 + static_cast<std::uint64_t>(second - 102));
  }
  EXPECT_EQ(left(200, 602), 398U) << "one in a second, of late";
  EXPECT_EQ(left(201, 0), std::nullopt) << "it began again";
  progress.phase = bake::Progress::Phase::index;
  EXPECT_EQ(left(204, 1000), std::nullopt);
}
TEST(JobId, IsThirtyTwoLowerCaseHexadecimalDigits) {
  EXPECT_TRUE(job::is_id("0123456789abcdef0123456789abcdef"));
  EXPECT_FALSE(job::is_id("0123456789ABCDEF0123456789abcdef"));
  EXPECT_FALSE(job::is_id("../56789abcdef0123456789abcdef01"));
  EXPECT_FALSE(job::is_id(""));
}

}  // namespace
