#include "server/job/store.hpp"

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using job::Status;
using job::Store;
using job::Time;
using std::chrono::milliseconds;
using testing::ElementsAre;

namespace {

Time at(std::int64_t ms) { return Time(milliseconds(ms)); }

job::Job job_of(char letter, Status status = Status::accepted) {
  job::Job job;
  job.id = std::string(32, letter);
  job.status = status;
  job.created = job.updated = at(1'700'000'000'000 + letter);
  return job;
}

class JobStore : public testing::Test {
 protected:
  std::vector<std::string> list(const job::Filter& filter) {
    std::vector<std::string> letters;
    for (const auto& job : store.list(filter, at(10'000))) letters.push_back(job.id.substr(0, 1));
    return letters;
  }
  void add(job::Job job) { ASSERT_TRUE(store.insert(job)); }

  TemporaryFolder folder;
  Store store{folder.path / "jobs.db"};
};

TEST_F(JobStore, GivesBackWhatItWasGiven) {
  auto job = job_of('a');
  job.process = "echo";
  job.owner = "ann";
  job.key = "k";
  job.fingerprint = "f";
  job.priority = -3;
  job.name = "caf\xc3\xa9";
  ASSERT_TRUE(store.insert(job));
  job.status = Status::failed;
  job.started = at(5);
  job.updated = at(9);
  job.problems = {{"/a", "is wrong"}};
  store.update(job);
  const auto back = store.find(job.id).value();
  EXPECT_EQ(back.serial, job.serial);
  EXPECT_EQ(back.status, Status::failed);
  EXPECT_EQ(back.process, "echo");
  EXPECT_EQ(back.owner, "ann");
  EXPECT_EQ(back.key, "k");
  EXPECT_EQ(back.fingerprint, "f");
  EXPECT_EQ(back.priority, -3);
  EXPECT_EQ(back.name, job.name);
  EXPECT_EQ(back.created, job.created);
  EXPECT_EQ(back.updated, at(9));
  EXPECT_EQ(back.started, at(5));
  EXPECT_FALSE(back.finished);
  EXPECT_EQ(back.problems.at(0).what, "is wrong");
  store.remove(job.id);
  EXPECT_FALSE(store.find(job.id));
}

TEST_F(JobStore, TakesAKeyOfOneOwnerOnce) {
  auto first = job_of('a'), second = job_of('b'), third = job_of('c');
  first.owner = second.owner = "ann";
  third.owner = "bob";
  first.key = second.key = third.key = "k";
  EXPECT_TRUE(store.insert(first));
  EXPECT_FALSE(store.insert(second));
  EXPECT_TRUE(store.insert(third));
  EXPECT_EQ(store.find_key("ann", "k")->id, first.id);
  EXPECT_FALSE(store.find_key("ann", ""));
  add(job_of('d'));
  add(job_of('e'));  // none has a key
}

TEST_F(JobStore, ListsNewestFirstWhatTheFilterLetsThrough) {
  add(job_of('a', Status::successful));
  auto started = job_of('b', Status::running);
  started.started = at(4'000);
  add(started);
  auto ended = job_of('c', Status::failed);
  ended.started = at(1'000);
  ended.finished = at(3'000);
  ended.process = "echo";
  add(ended);
  add(job_of('d'));
  EXPECT_THAT(list({}), ElementsAre("d", "c", "b", "a"));
  job::Filter filter;
  filter.statuses = {Status::failed, Status::successful};
  EXPECT_THAT(list(filter), ElementsAre("c", "a"));
  filter = {};
  filter.processes = {"echo"};
  EXPECT_THAT(list(filter), ElementsAre("c"));
  filter = {};
  filter.shortest = 3'000;  // the one that runs has run for six seconds
  EXPECT_THAT(list(filter), ElementsAre("b"));
  filter = {};
  filter.longest = 3'000;
  EXPECT_THAT(list(filter), ElementsAre("c"));
  filter = {};
  filter.from = at(1'700'000'000'000 + 'b');
  filter.to = at(1'700'000'000'000 + 'c');
  EXPECT_THAT(list(filter), ElementsAre("c", "b"));
  filter = {};
  filter.limit = 2;
  EXPECT_THAT(list(filter), ElementsAre("d", "c"));
  filter.before = store.find(std::string(32, 'c'))->serial;
  EXPECT_THAT(list(filter), ElementsAre("b", "a"));
  filter = {};
  filter.owner = "nobody";
  EXPECT_TRUE(list(filter).empty());
}

TEST_F(JobStore, IsOnDiskAtOnce) {
  add(job_of('a', Status::running));
  Store other(folder.path / "jobs.db");
  ASSERT_TRUE(other.find(std::string(32, 'a')));
  other.interrupt_all();
  EXPECT_EQ(other.find(std::string(32, 'a'))->status, Status::accepted);
  EXPECT_EQ(other.first_waiting()->id, std::string(32, 'a'));
  EXPECT_EQ(other.count(Status::accepted), 1U);
  EXPECT_EQ(other.count(Status::accepted, "ann"), 0U);
}

TEST_F(JobStore, KeepsReportsApart) {
  auto job = job_of('a');
  job.owner = "ann";
  add(job);
  EXPECT_EQ(store.report(job.id), "");
  job.status = Status::successful;
  job.outcome.report = std::make_shared<const nlohmann::json>(nlohmann::json{{"sinks", 3}});
  store.update(job);
  EXPECT_EQ(store.report(job.id), R"({"sinks":3})");
  EXPECT_EQ(store.find(job.id)->outcome.report, nullptr);
  EXPECT_EQ(store.list({}, at(0)).at(0).outcome.report, nullptr);
  store.set_bytes(job.id, 100);
  EXPECT_EQ(store.bytes_of("ann"), 111U) << "the report is counted";
  store.remove(job.id);
  EXPECT_EQ(store.report(job.id), "");
}

TEST(JobStoreOfVersionTwo, HasItsReportsTakenOutOfItsRows) {
  const TemporaryFolder folder;
  const auto file = folder.path / "jobs.db";
  {
    Store store(file);
    for (const char letter : {'a', 'b', 'c'}) {
      auto job = job_of(letter, Status::successful);
      ASSERT_TRUE(store.insert(job));
    }
  }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database,
                         "DROP TABLE reports; PRAGMA user_version = 2; "
                         "UPDATE jobs SET state = json_set(state, '$.report', "
                         "json('{\"x\": [1.50, \"\u00e9\"]}')) WHERE id LIKE 'a%'; "
                         "UPDATE jobs SET state = json_set(state, '$.report', null) "
                         "WHERE id LIKE 'b%'; UPDATE jobs SET state = '{' WHERE id LIKE 'c%';",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  const Store store(file);
  EXPECT_EQ(nlohmann::json::parse(store.report(std::string(32, 'a'))),
            nlohmann::json::parse(R"({"x": [1.50, "\u00e9"]})"));
  EXPECT_EQ(store.find(std::string(32, 'a'))->status, Status::successful);
  EXPECT_EQ(store.report(std::string(32, 'b')), "");
  EXPECT_EQ(store.find(std::string(32, 'b'))->status, Status::successful);
  EXPECT_EQ(store.find(std::string(32, 'c'))->status, Status::failed) << "one bad row, as before";
}

TEST_F(JobStore, MakesAFailedJobOfADamagedRow) {
  add(job_of('a'));
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path / "jobs.db").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "UPDATE jobs SET state = 'x'", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_EQ(store.find(std::string(32, 'a'))->status, Status::failed);
}

/// The connection that was opened last.
sqlite3* opened = nullptr;
int note_opened(sqlite3* connection, char**, const void*) {
  opened = connection;
  return SQLITE_OK;
}

/// What a connection says of one of its settings.
std::string setting(sqlite3* connection, const std::string& name) {
  std::string value;
  const auto take = [](void* to, int, char** values, char**) {
    *static_cast<std::string*>(to) = values[0];
    return 0;
  };
  sqlite3_exec(connection, ("PRAGMA " + name).c_str(), take, &value, nullptr);
  return value;
}

TEST_F(JobStore, WaitsForTheDiskAtEveryChange) {
  // How long to wait is a matter of each connection: only the store's own can tell.
  const auto note = reinterpret_cast<void (*)()>(note_opened);
  ASSERT_EQ(sqlite3_auto_extension(note), SQLITE_OK);
  const Store own(folder.path / "own.db");
  sqlite3_cancel_auto_extension(note);
  ASSERT_NE(opened, nullptr);
  EXPECT_EQ(setting(opened, "synchronous"), "2");
  EXPECT_EQ(setting(opened, "journal_mode"), "wal");
}

TEST_F(JobStore, RefusesAFileOfANewerRelease) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path / "new.db").c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_THROW(Store(folder.path / "new.db"), Error);
}

}  // namespace
