#include <gmock/gmock.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>

#include "server/job/queue.hpp"
#include "server/job/state.hpp"
#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using job::Event;
using job::Queue;
using job::Status;
using std::chrono::milliseconds;
using Try = Queue::Try;

namespace {

class Outbox : public testing::Test {
 protected:
  job::Settings settings() const {
    job::Settings settings;
    settings.data = folder.path / "data";
    settings.announce = [](const job::Job& job, const std::filesystem::path&) {
      return job.id + " is " + job::name_of(job.status);
    };
    return settings;
  }
  void open(std::function<job::Outcome(const job::Work&)> run) { open(settings(), std::move(run)); }
  void open(const job::Settings& with, std::function<job::Outcome(const job::Work&)> run) {
    queue.reset();
    queue.emplace(with, engine_of(std::move(run)));
  }
  std::string submit() {
    auto request = bake_of(good_scene());
    request.subscriber = {"http://a/yes", "http://a/begun", "http://a/no"};
    return queue->submit(request).job.id;
  }
  /// What is due within ten seconds, where anything is.
  std::optional<job::Delivery> next() {
    std::stop_source late;
    const std::jthread watch([&](const std::stop_token& stop) {
      for (int i = 0; i < 1000 && !stop.stop_requested(); ++i) {
        std::this_thread::sleep_for(milliseconds(10));
      }
      late.request_stop();
    });
    return queue->next_delivery(late.get_token());
  }

  TemporaryFolder folder;
  std::optional<Queue> queue;
};

TEST_F(Outbox, OwesWhatAJobCameToInTheWordsOfThatMoment) {
  open([](const auto&) { return finished(); });
  const auto id = submit();
  wait_for(*queue, id, Status::successful);
  EXPECT_EQ(queue->told().pending, 2U);
  const auto begun = next().value();
  EXPECT_EQ(begun.event, Event::in_progress);
  EXPECT_EQ(begun.uri, "http://a/begun");
  EXPECT_EQ(begun.body, id + " is running");
  EXPECT_EQ(job::id_of(begun), id + "-inProgress");
  queue->tried(begun, Try::taken, milliseconds(1));
  const auto done = next().value();
  EXPECT_EQ(done.event, Event::success);
  EXPECT_EQ(done.uri, "http://a/yes");
  EXPECT_EQ(done.body, id + " is successful");
  queue->tried(done, Try::taken, milliseconds(1));
  EXPECT_EQ(queue->told().pending, 0U);
  EXPECT_EQ(queue->told().delivered, 2U);
}

TEST_F(Outbox, TellsOfAFailure) {
  open([](const auto&) -> job::Outcome { throw Error(Fault::limit, "/a", "is too large"); });
  const auto id = submit();
  wait_for(*queue, id, Status::failed);
  queue->tried(next().value(), Try::taken, milliseconds(1));
  const auto failed = next().value();
  EXPECT_EQ(failed.event, Event::failed);
  EXPECT_EQ(failed.uri, "http://a/no");
}

TEST_F(Outbox, KeepsWhatItOwesForTheNextQueueAndOwesNothingTwice) {
  open([](const auto&) { return finished(); });
  const auto first = submit();
  wait_for(*queue, first, Status::successful);
  open(until_stopped);
  EXPECT_EQ(next()->job, first);
  const auto second = submit();
  wait_for(*queue, second, Status::running);
  EXPECT_EQ(queue->told().pending, 3U);
  open(until_stopped);  // the second job begins again
  wait_for(*queue, second, Status::running);
  EXPECT_EQ(queue->told().pending, 3U);
  auto silent = settings();
  silent.announce = nullptr;
  open(silent, until_stopped);
  EXPECT_EQ(queue->told().pending, 0U) << "where there are no callbacks nothing is owed";
}

TEST_F(Outbox, TriesAgainAfterGrowingPausesAndGivesUp) {
  EXPECT_EQ(job::pause_after(1, milliseconds(10)), milliseconds(10));
  EXPECT_EQ(job::pause_after(2, milliseconds(10)), milliseconds(20));
  EXPECT_EQ(job::pause_after(5, milliseconds(10)), milliseconds(160));
  open([](const auto&) { return finished(); });
  const auto id = submit();
  wait_for(*queue, id, Status::successful);
  queue->tried(next().value(), Try::may_not, milliseconds(1));  // at once
  EXPECT_EQ(queue->told().given_up, 1U);
  auto before = job::now();
  for (int tries = 0; tries < job::most_tries; ++tries) {
    const auto delivery = next().value();
    if (tries == 1) {
      EXPECT_GE(job::now() - before, milliseconds(40));
    }
    EXPECT_EQ(delivery.tries, tries);
    EXPECT_EQ(delivery.event, Event::success);
    before = job::now();
    queue->tried(delivery, Try::failed, milliseconds(40));
  }
  EXPECT_EQ(queue->told().pending, 0U);
  EXPECT_EQ(queue->told().given_up, 2U);
  EXPECT_EQ(queue->told().failed_tries, 6U);
}

TEST_F(Outbox, CallsOneHostOnceAtATime) {
  EXPECT_EQ(job::host_of("https://A.example:8443/x?y#z"), "a.example:8443");
  EXPECT_EQ(job::host_of("http://a?x"), "a");
  open([](const auto&) { return finished(); });
  wait_for(*queue, submit(), Status::successful);
  const auto first = next().value();
  EXPECT_EQ(queue->told().pending, 2U);
  auto other = bake_of(good_scene());
  other.subscriber.success = "http://b/yes";
  wait_for(*queue, queue->submit(other).job.id, Status::successful);
  const auto second = next().value();
  EXPECT_EQ(second.uri, "http://b/yes") << "the next one to a waits";
  queue->tried(first, Try::taken, milliseconds(1));
  EXPECT_EQ(next()->uri, "http://a/yes");
}

TEST_F(Outbox, ForgetsADismissedJobEvenDuringATry) {
  open(until_stopped);
  const auto id = submit();
  wait_for(*queue, id, Status::running);
  const auto under_way = next().value();
  queue->dismiss(id);
  EXPECT_EQ(queue->told().pending, 0U);
  queue->tried(under_way, Try::failed, milliseconds(1));
  EXPECT_EQ(queue->told().pending, 0U);
}

TEST_F(Outbox, KeepsAnOldJobUntilItsCallbacksAreSettled) {
  auto with = settings();
  with.keep = std::chrono::seconds(1);
  open(with, [](const auto&) { return finished(); });
  const auto id = submit();
  const auto silent = queue->submit(bake_of(good_scene())).job.id;
  wait_for(*queue, id, Status::successful);
  const auto gone = [&](const std::string& which) {
    for (int i = 0; i < 1000 && queue->find(which); ++i) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return !queue->find(which);
  };
  EXPECT_TRUE(gone(silent));
  EXPECT_TRUE(queue->find(id));
  queue->tried(next().value(), Try::taken, milliseconds(1));
  queue->tried(next().value(), Try::taken, milliseconds(1));
  EXPECT_TRUE(gone(id));
}

TEST_F(Outbox, TakesUpTheDataOfAnEarlierRelease) {
  open(until_stopped);
  const auto id = submit();
  queue.reset();
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path / "data/jobs.db").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(
      sqlite3_exec(database,
                   "DROP TABLE deliveries; DROP TABLE uses; DROP TABLE assets; DROP TABLE reports; "
                   "ALTER TABLE jobs DROP COLUMN bytes; PRAGMA user_version = 1;",
                   nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(database);
  open([](const auto&) { return finished(); });
  wait_for(*queue, id, Status::successful);
  EXPECT_EQ(queue->told().pending, 2U);
}

}  // namespace
