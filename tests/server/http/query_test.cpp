#include "server/http/query.hpp"

#include <gmock/gmock.h>

#include "engine/base/error.hpp"

using namespace hoodoo;
using http::filter_of;
using http::parse_query;
using http::parse_time;
using testing::ElementsAre;
using testing::SizeIs;

namespace {

job::Filter filter(std::string_view query) { return filter_of(parse_query(query)); }

TEST(Query, IsDecoded) {
  const auto query = parse_query("a=x%20y+z&b=&c&a=2");
  EXPECT_EQ(query.at("a"), "x y z,2");
  EXPECT_EQ(query.at("b"), "");
  EXPECT_EQ(query.at("c"), "");
  EXPECT_TRUE(parse_query("").empty());
  for (const auto* bad : {"a=%", "a=%2", "a=%zz", "a=%00"}) {
    EXPECT_THROW(parse_query(bad), Error) << bad;
  }
}
TEST(Query, OfAJobListBecomesAFilter) {
  const auto all = filter("");
  EXPECT_EQ(all.limit, 10U);
  EXPECT_TRUE(all.statuses.empty());
  const auto some = filter(
      "limit=3&status=failed,running&processID=echo&minDuration=2&maxDuration=5&before=77"
      "&datetime=2026-01-01T00:00:00Z/..&type=process");
  EXPECT_EQ(some.limit, 3U);
  EXPECT_THAT(some.statuses, ElementsAre(job::Status::failed, job::Status::running));
  EXPECT_THAT(some.processes, ElementsAre("echo"));
  EXPECT_EQ(some.shortest, 2000);
  EXPECT_EQ(some.longest, 5000);
  EXPECT_EQ(some.before, 77U);
  EXPECT_EQ(some.from, parse_time("2026-01-01T00:00:00Z"));
  EXPECT_FALSE(some.to);
  EXPECT_EQ(filter("limit=99999999").limit, 10'000U) << "more may be asked for than is given";
}
TEST(Query, ThatIsWrongIsRefusedWithAllThatIsWrong) {
  try {
    filter("limit=0&status=frozen&minDuration=-1&bogus=1&datetime=soon&before=x");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.problems, SizeIs(6));
  }
}
TEST(Query, OfTheNextPageKeepsTheFilter) {
  const auto query = parse_query("status=failed&datetime=2026-01-01T00:00:00Z/..&before=9");
  EXPECT_EQ(parse_query(http::next_page(query, 5)).at("before"), "5");
  EXPECT_EQ(filter(http::next_page(query, 5)).from, filter_of(query).from);
}
TEST(Time, IsReadFromRfc3339) {
  using std::chrono::milliseconds;
  EXPECT_EQ(parse_time("1970-01-01T00:00:01Z")->time_since_epoch(), milliseconds(1000));
  EXPECT_EQ(parse_time("1970-01-01T01:00:00.25+01:00")->time_since_epoch(), milliseconds(250));
  EXPECT_EQ(parse_time("1969-12-31T23:00:00-01:00")->time_since_epoch(), milliseconds(0));
  for (const auto* bad : {"", "1970-01-01", "1970-13-01T00:00:00Z", "1970-02-30T00:00:00Z",
                          "1970-01-01T24:00:00Z", "1970-01-01T00:00:00", "1970-01-01T00:00:00.Z",
                          "1970-01-01T00:00:00+1", "1970-01-01T00:00:00Zx"}) {
    EXPECT_FALSE(parse_time(bad)) << bad;
  }
}
TEST(Preferences, OfARequestAreUnderstood) {
  http::Request request;
  EXPECT_FALSE(http::preferences_of(request).respond_async);
  request.headers["prefer"] = "respond-async, wait=20; x=1";
  EXPECT_TRUE(http::preferences_of(request).respond_async);
  EXPECT_EQ(http::preferences_of(request).wait, 20);
  request.headers["prefer"] = "wait=100000";
  EXPECT_EQ(http::preferences_of(request).wait, http::most_wait);
  for (const auto* wait : {"wait=4294967296", "wait=99999999999999999999", "WAIT = \"61\""}) {
    request.headers["prefer"] = wait;
    EXPECT_EQ(http::preferences_of(request).wait, http::most_wait) << wait;
  }
  request.headers["prefer"] = "Respond-Async, Wait=20";
  EXPECT_TRUE(http::preferences_of(request).respond_async);
  EXPECT_EQ(http::preferences_of(request).wait, 20);
  for (const auto* other :
       {"wait=-1", "wait=+1", "wait", "wait=", "waits=20", "respond-asynchronously"}) {
    request.headers["prefer"] = other;
    EXPECT_EQ(http::preferences_of(request).wait, 0) << other;
    EXPECT_FALSE(http::preferences_of(request).respond_async) << other;
  }
  request.headers["prefer"] = "wait=soon";
  EXPECT_EQ(http::preferences_of(request).wait, 0);
}

}  // namespace
