#include "server/job/queue.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <map>
#include <nlohmann/json.hpp>

#include "server/job/database.hpp"
#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using job::Queue;
using job::Status;
using testing::ElementsAre;

namespace {

using Kind = job::Submitted::Kind;

std::vector<job::Job> all(const Queue& queue) {
  job::Filter filter;
  filter.limit = 1000;
  return queue.list(filter);
}

TEST(Queue, BakesAJobIntoItsOwnFolder) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto& work) {
                std::filesystem::create_directories(work.folder / "out");
                std::ofstream(work.folder / "out/tileset.json") << "{}";
                return finished();
              }));
  const auto taken = queue.submit(bake_of(good_scene()));
  ASSERT_EQ(taken.kind, Kind::taken);
  const auto& job = taken.job;
  EXPECT_TRUE(job::is_id(job.id));
  EXPECT_EQ(job.name, "hill");
  const auto done = wait_for(queue, job.id, Status::successful);
  EXPECT_TRUE(done.outcome.complete);
  EXPECT_EQ(done.outcome.progress.done, 3U);
  EXPECT_GT(done.updated, job.updated);
  EXPECT_TRUE(done.started && done.finished);
  EXPECT_TRUE(std::filesystem::exists(queue.results(job.id) / "tileset.json"));
}

TEST(Queue, RefusesASceneWithAllItsProblemsAndKeepsNothing) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto&) { return finished(); }));
  try {
    queue.submit(bake_of({{"bad", 1}}));
    FAIL() << "took a bad scene";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    EXPECT_EQ(error.problems.at(0).where, "/bad");
  }
  EXPECT_TRUE(all(queue).empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path / "data/jobs"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path / "data/checks"));
}

TEST(Queue, FreesTheKeyOfAJobThatFailedOrWasDismissed) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const job::Work& work) -> job::Outcome {
                if (work.inputs.at("fails").get<bool>()) throw Error(Fault::limit, "", "too much");
                return until_stopped(work);
              }));
  job::Request request{"echo", {{"fails", true}}, 0, "ann", "k"};
  const auto first = queue.submit(request).job.id;
  wait_for(queue, first, Status::failed);
  request.inputs = {{"fails", false}};
  const auto second = queue.submit(request);
  ASSERT_EQ(second.kind, Kind::taken);
  EXPECT_NE(second.job.id, first);
  EXPECT_EQ(queue.submit(request).job.id, second.job.id);
  queue.dismiss(second.job.id);
  EXPECT_EQ(queue.submit(request).kind, Kind::taken);
  EXPECT_TRUE(queue.find(first)) << "it is kept";
}

TEST(Queue, GivesTheReportsOfJobsApart) {
  const TemporaryFolder folder;
  const auto large = std::string(1 << 20, 'x');
  const auto run = [&](const job::Work& work) {
    auto outcome = finished();
    outcome.report = std::make_shared<const nlohmann::json>(
        nlohmann::json{{"text", large + work.inputs.at("which").get<std::string>()}});
    return outcome;
  };
  std::vector<std::string> ids;
  {
    Queue queue(settings_in(folder), engine_of(run));
    for (const auto* which : {"a", "b", "c"}) {
      ids.push_back(queue.submit({"diff-tilesets", {{"which", which}}, 0, "", ""}).job.id);
    }
    for (const auto& id : ids) wait_for(queue, id, Status::successful);
    EXPECT_EQ(queue.report(ids[1])->at("text"), large + "b");
  }
  Queue queue(settings_in(folder), engine_of(run));
  for (const auto& job : all(queue)) EXPECT_EQ(job.outcome.report, nullptr);
  EXPECT_EQ(queue.find(ids[2])->outcome.report, nullptr);
  EXPECT_EQ(queue.report(ids[2])->at("text"), large + "c");
  EXPECT_EQ(queue.report(std::string(32, '0')), nullptr);
}

TEST(Queue, BakesOneJobAtATimeInTheOrderOfSubmission) {
  const TemporaryFolder folder;
  std::atomic<int> at_once = 0, most = 0;
  Queue queue(settings_in(folder), engine_of([&](const auto&) {
                most = std::max(most.load(), ++at_once);
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                --at_once;
                return finished();
              }));
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) ids.push_back(queue.submit(bake_of(good_scene())).job.id);
  std::vector<job::Time> starts;
  for (const auto& id : ids) {
    starts.push_back(*wait_for(queue, id, Status::successful).started);
  }
  EXPECT_EQ(most, 1);
  EXPECT_TRUE(std::ranges::is_sorted(starts));
  EXPECT_EQ(all(queue).front().id, ids.back());
}

TEST(Queue, TakesNoMoreJobsThanMayWait) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.most_waiting = 1;
  Queue queue(settings, engine_of(until_stopped));
  const auto running = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, running, Status::running);
  EXPECT_EQ(queue.submit(bake_of(good_scene())).kind, Kind::taken);
  EXPECT_TRUE(queue.is_full());
  EXPECT_EQ(queue.submit(bake_of(good_scene())).kind, Kind::queue_full);
  EXPECT_EQ(all(queue).size(), 2U);
}

TEST(Queue, LetsNoOwnerFillIt) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.most_of_owner = 1;
  Queue queue(settings, engine_of(until_stopped));
  wait_for(queue, queue.submit(bake_of(good_scene())).job.id, Status::running);
  auto request = bake_of(good_scene());
  request.owner = "ann";
  EXPECT_EQ(queue.submit(request).kind, Kind::taken);
  EXPECT_EQ(queue.submit(request).kind, Kind::owner_full);
  request.owner = "bob";
  EXPECT_EQ(queue.submit(request).kind, Kind::taken);
}

TEST(Queue, StartsTheHighestPriorityFirst) {
  const TemporaryFolder folder;
  std::vector<std::string> order;
  std::atomic<bool> open = false;
  Queue queue(settings_in(folder), engine_of([&](const auto& work) {
                while (!open) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                order.push_back(work.folder.filename());
                return finished();
              }));
  const auto first = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, first, Status::running);
  std::map<int, std::string> ids;
  for (const int priority : {-1, 0, 5}) {
    auto request = bake_of(good_scene());
    request.priority = priority;
    ids[priority] = queue.submit(request).job.id;
  }
  open = true;
  wait_for(queue, ids[-1], Status::successful);
  EXPECT_THAT(order, ElementsAre(first, ids[5], ids[0], ids[-1]));
}

TEST(Queue, RunsAsManyAtOnceAsItIsTold) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.at_once = 2;
  Queue queue(settings, engine_of(until_stopped));
  const auto one = queue.submit(bake_of(good_scene())).job.id;
  const auto two = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, one, Status::running);
  wait_for(queue, two, Status::running);
}

TEST(Queue, AnswersAKeyThatCameBeforeWithItsJob) {
  const TemporaryFolder folder;
  auto request = bake_of(good_scene());
  request.owner = "ann";
  request.key = "k1";
  std::string id;
  {
    Queue queue(settings_in(folder), engine_of(until_stopped));
    id = queue.submit(request).job.id;
    const auto again = queue.submit(request);
    EXPECT_EQ(again.kind, Kind::replayed);
    EXPECT_EQ(again.job.id, id);
  }
  Queue queue(settings_in(folder), engine_of(until_stopped));
  EXPECT_EQ(queue.submit(request).job.id, id) << "after a restart";
  auto other = request;
  other.inputs["scene"]["name"] = "valley";
  EXPECT_EQ(queue.submit(other).kind, Kind::key_reused);
  other.owner = "bob";
  EXPECT_EQ(queue.submit(other).kind, Kind::taken);
}

TEST(Queue, MakesOneJobOfOneKeyHoweverManyAskAtOnce) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of(until_stopped));
  auto request = bake_of(good_scene());
  request.key = "k1";
  std::atomic<int> taken = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] { taken += queue.submit(request).kind == Kind::taken ? 1 : 0; });
    }
  }
  EXPECT_EQ(taken, 1);
  EXPECT_EQ(all(queue).size(), 1U);
}

TEST(Queue, StopsARunningJobThatIsDismissedAndGoesOnToTheNext) {
  const TemporaryFolder folder;
  std::atomic<int> bakes = 0;
  Queue queue(settings_in(folder), engine_of([&](const auto& work) {
                return ++bakes == 1 ? until_stopped(work) : finished();
              }));
  const auto first = queue.submit(bake_of(good_scene())).job.id,
             second = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, first, Status::running);
  EXPECT_EQ(queue.dismiss(first)->status, Status::dismissed);
  wait_for(queue, second, Status::successful);
  EXPECT_EQ(queue.find(first)->status, Status::dismissed);
  EXPECT_FALSE(queue.dismiss("0123456789abcdef0123456789abcdef"));
}

TEST(Queue, RemovesAnEndedJobThatIsDismissed) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto&) { return finished(); }));
  const auto id = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, id, Status::successful);
  EXPECT_TRUE(queue.dismiss(id));
  EXPECT_FALSE(queue.find(id));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path / "data/jobs"));
}

TEST(Queue, RemovesJobsSomeTimeAfterTheyEnded) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.keep = std::chrono::seconds(1);
  settings.at_once = 2;
  Queue queue(settings, engine_of([](const job::Work& work) {
                const auto scene =
                    nlohmann::json::parse(read_file(work.folder / "scene.json", 1U << 20));
                return scene.contains("long") ? until_stopped(work) : finished();
              }));
  auto slow = good_scene();
  slow["long"] = 1;
  const auto running = queue.submit(bake_of(slow)).job.id;
  const auto ended = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, ended, Status::successful);
  for (int i = 0; i < 1000 && queue.find(ended); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_FALSE(queue.find(ended));
  EXPECT_FALSE(std::filesystem::exists(queue.results(ended)));
  EXPECT_EQ(queue.find(running)->status, Status::running);
}

TEST(Queue, KeepsWhyAJobFailed) {
  const TemporaryFolder folder;
  {
    Queue queue(settings_in(folder), engine_of([](const auto&) -> job::Outcome {
                  throw Error(Fault::io, "disk", "is full");
                }));
    const auto id = queue.submit(bake_of(good_scene())).job.id;
    EXPECT_EQ(wait_for(queue, id, Status::failed).fault, Fault::io);
  }
  Queue queue(settings_in(folder), engine_of([](const auto&) { return finished(); }));
  ASSERT_EQ(all(queue).size(), 1U);
  EXPECT_EQ(all(queue)[0].status, Status::failed);
  EXPECT_EQ(all(queue)[0].problems.at(0).what, "is full");
}

TEST(Queue, WritesTheEndOfAJobAsSoonAsItCan) {
  const TemporaryFolder folder;
  std::unique_ptr<job::Database> other;
  Queue queue(settings_in(folder), engine_of([&](const auto&) {
                other = std::make_unique<job::Database>(folder.path / "data/jobs.db");
                other->execute("BEGIN IMMEDIATE");  // nobody else can write, as on a full disk
                return finished();
              }));
  const auto id = queue.submit(bake_of(good_scene())).job.id;
  wait_for(queue, id, Status::successful);
  EXPECT_EQ(queue.count(Status::successful), 0U);
  other->execute("COMMIT");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (queue.count(Status::successful) == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(queue.count(Status::successful), 1U);
  EXPECT_EQ(queue.find(id)->status, Status::successful);
}

TEST(Queue, ContinuesWhatAnEarlierOneDidNotFinish) {
  const TemporaryFolder folder;
  std::string running, waiting;
  {
    Queue queue(settings_in(folder), engine_of([](const auto& work) {
                  std::filesystem::create_directories(work.folder / "out");
                  std::ofstream(work.folder / "out/half") << "done";
                  std::ofstream(work.folder / "out/tile.glb.part") << "half";
                  return until_stopped(work);
                }));
    running = queue.submit(bake_of(good_scene())).job.id;
    waiting = queue.submit(bake_of(good_scene())).job.id;
    wait_for(queue, running, Status::running);
  }
  std::vector<std::string> order;
  Queue queue(settings_in(folder), engine_of([&](const auto& work) {
                order.push_back(work.folder.filename());
                return finished();
              }));
  wait_for(queue, waiting, Status::successful);
  EXPECT_THAT(order, ElementsAre(running, waiting));
  EXPECT_TRUE(std::filesystem::exists(queue.results(running) / "half"));
  EXPECT_FALSE(std::filesystem::exists(queue.results(running) / "tile.glb.part"));
  const auto later = queue.submit(bake_of(good_scene())).job;
  EXPECT_GT(later.serial, queue.find(waiting)->serial);
}

TEST(Queue, SweepsAFolderWithoutState) {
  const TemporaryFolder folder;
  const std::string id(32, 'a');
  folder.write("data/jobs/" + id + "/scene.json", "{}");
  folder.write("data/jobs/notes.txt", "not a job");
  const Queue queue(settings_in(folder), engine_of([](const auto&) { return finished(); }));
  EXPECT_FALSE(std::filesystem::exists(folder.path / "data/jobs" / id));
  EXPECT_TRUE(std::filesystem::exists(folder.path / "data/jobs/notes.txt"));
}

TEST(Queue, LetsNoSecondProcessUseItsData) {
  const TemporaryFolder folder;
  const auto engine = engine_of([](const auto&) { return finished(); });
  const Queue queue(settings_in(folder), engine);
  EXPECT_THROW(Queue(settings_in(folder), engine), Error);
}

TEST(Queue, WhoseStoreIsDamagedSaysSo) {
  const TemporaryFolder folder;
  folder.write("data/jobs.db", std::string(8192, 'x'));
  const auto engine = engine_of([](const auto&) { return finished(); });
  EXPECT_THROW(Queue(settings_in(folder), engine), Error);
}

}  // namespace
