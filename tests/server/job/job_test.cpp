#include "server/job/job.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using job::Queue;
using job::Status;
using testing::ElementsAre;

namespace {

job::Settings settings_in(const TemporaryFolder& folder) {
  job::Settings settings;
  settings.data = folder.path / "data";
  return settings;
}

TEST(Queue, BakesAJobIntoItsOwnFolder) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto& out, const auto&) {
                std::filesystem::create_directories(out);
                std::ofstream(out / "tileset.json") << "{}";
                return finished();
              }));
  const auto job = queue.submit(good_scene());
  ASSERT_TRUE(job);
  EXPECT_TRUE(job::is_id(job->id));
  EXPECT_EQ(job->name, "hill");
  const auto done = wait_for(queue, job->id, Status::successful);
  EXPECT_TRUE(done.complete);
  EXPECT_EQ(done.progress.done, 3U);
  EXPECT_TRUE(done.started && done.finished);
  EXPECT_TRUE(std::filesystem::exists(queue.tileset(job->id) / "tileset.json"));
}

TEST(Queue, RefusesASceneWithAllItsProblemsAndKeepsNothing) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto&, const auto&) { return finished(); }));
  try {
    queue.submit({{"bad", 1}});
    FAIL() << "took a bad scene";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    EXPECT_EQ(error.problems.at(0).where, "/bad");
  }
  EXPECT_TRUE(queue.list().empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path / "data/jobs"));
}

TEST(Queue, BakesOneJobAtATimeInTheOrderOfSubmission) {
  const TemporaryFolder folder;
  std::atomic<int> at_once = 0, most = 0;
  Queue queue(settings_in(folder), engine_of([&](const auto&, const auto&) {
                most = std::max(most.load(), ++at_once);
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                --at_once;
                return finished();
              }));
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) ids.push_back(queue.submit(good_scene())->id);
  std::vector<job::Time> starts;
  for (const auto& id : ids) {
    starts.push_back(*wait_for(queue, id, Status::successful).started);
  }
  EXPECT_EQ(most, 1);
  EXPECT_TRUE(std::ranges::is_sorted(starts));
  EXPECT_EQ(queue.list().front().id, ids.back());
}

TEST(Queue, TakesNoMoreJobsThanMayWait) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.most_waiting = 1;
  Queue queue(settings,
              engine_of([](const auto&, const auto& bake) { return until_stopped(bake); }));
  const auto running = queue.submit(good_scene());
  wait_for(queue, running->id, Status::running);
  EXPECT_TRUE(queue.submit(good_scene()));
  EXPECT_FALSE(queue.submit(good_scene()));
  EXPECT_EQ(queue.list().size(), 2U);
}

TEST(Queue, StopsARunningJobThatIsDismissedAndGoesOnToTheNext) {
  const TemporaryFolder folder;
  std::atomic<int> bakes = 0;
  Queue queue(settings_in(folder), engine_of([&](const auto&, const auto& bake) {
                return ++bakes == 1 ? until_stopped(bake) : finished();
              }));
  const auto first = queue.submit(good_scene())->id, second = queue.submit(good_scene())->id;
  wait_for(queue, first, Status::running);
  EXPECT_EQ(queue.dismiss(first)->status, Status::dismissed);
  wait_for(queue, second, Status::successful);
  EXPECT_EQ(queue.find(first)->status, Status::dismissed);
  EXPECT_FALSE(queue.dismiss("0123456789abcdef0123456789abcdef"));
}

TEST(Queue, RemovesAnEndedJobThatIsDismissed) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of([](const auto&, const auto&) { return finished(); }));
  const auto id = queue.submit(good_scene())->id;
  wait_for(queue, id, Status::successful);
  EXPECT_TRUE(queue.dismiss(id));
  EXPECT_FALSE(queue.find(id));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path / "data/jobs"));
}

TEST(Queue, KeepsWhyAJobFailed) {
  const TemporaryFolder folder;
  {
    Queue queue(settings_in(folder), engine_of([](const auto&, const auto&) -> bake::Report {
                  throw Error(Fault::io, "disk", "is full");
                }));
    const auto id = queue.submit(good_scene())->id;
    EXPECT_EQ(wait_for(queue, id, Status::failed).fault, Fault::io);
  }
  Queue queue(settings_in(folder), engine_of([](const auto&, const auto&) { return finished(); }));
  ASSERT_EQ(queue.list().size(), 1U);
  EXPECT_EQ(queue.list()[0].status, Status::failed);
  EXPECT_EQ(queue.list()[0].problems.at(0).what, "is full");
}

TEST(Queue, ContinuesWhatAnEarlierOneDidNotFinish) {
  const TemporaryFolder folder;
  std::string running, waiting;
  {
    Queue queue(settings_in(folder), engine_of([](const auto& out, const auto& bake) {
                  std::filesystem::create_directories(out);
                  std::ofstream(out / "half") << "done";
                  return until_stopped(bake);
                }));
    running = queue.submit(good_scene())->id;
    waiting = queue.submit(good_scene())->id;
    wait_for(queue, running, Status::running);
  }
  std::vector<std::string> order;
  Queue queue(settings_in(folder), engine_of([&](const auto& out, const auto&) {
                order.push_back(out.parent_path().filename());
                return finished();
              }));
  wait_for(queue, waiting, Status::successful);
  EXPECT_THAT(order, ElementsAre(running, waiting));
  EXPECT_TRUE(std::filesystem::exists(queue.tileset(running) / "half"));
  const auto later = queue.submit(good_scene());
  EXPECT_GT(later->serial, queue.find(waiting)->serial);
}

TEST(Queue, SweepsAFolderWithoutState) {
  const TemporaryFolder folder;
  const std::string id(32, 'a');
  folder.write("data/jobs/" + id + "/scene.json", "{}");
  folder.write("data/jobs/notes.txt", "not a job");
  const Queue queue(settings_in(folder),
                    engine_of([](const auto&, const auto&) { return finished(); }));
  EXPECT_FALSE(std::filesystem::exists(folder.path / "data/jobs" / id));
  EXPECT_TRUE(std::filesystem::exists(folder.path / "data/jobs/notes.txt"));
}

TEST(Queue, LetsNoSecondProcessUseItsData) {
  const TemporaryFolder folder;
  const auto engine = engine_of([](const auto&, const auto&) { return finished(); });
  const Queue queue(settings_in(folder), engine);
  EXPECT_THROW(Queue(settings_in(folder), engine), Error);
}

TEST(Queue, LetsNoFileBeNamedWithoutARoot) {
  const TemporaryFolder folder;
  auto engine = engine_of([](const auto&, const auto&) { return finished(); });
  scene::Sources seen;
  engine.check = [&](const nlohmann::json&, const scene::Sources& sources) {
    seen = sources;
    return std::vector<Problem>();
  };
  Queue queue(settings_in(folder), engine);
  queue.submit(good_scene());
  ASSERT_EQ(seen.roots.size(), 1U);
  EXPECT_TRUE(std::filesystem::is_empty(seen.roots[0]));
  EXPECT_EQ(seen.base, seen.roots[0]);
}

TEST(Queue, CountsRelativePathsFromTheRootThatHasTheFiles) {
  const TemporaryFolder folder;
  folder.write("one/other.tif", "");
  folder.write("two/dem.tif", "");
  auto settings = settings_in(folder);
  settings.roots = {folder.path / "one", folder.path / "two"};
  auto engine = engine_of([](const auto&, const auto&) { return finished(); });
  std::filesystem::path base;
  engine.check = [&](const nlohmann::json&, const scene::Sources& sources) {
    base = sources.base;
    std::vector<Problem> problems;
    if (!std::filesystem::exists(base / "dem.tif")) problems = {{"/dem", "is not there"}};
    return problems;
  };
  Queue queue(settings, engine);
  EXPECT_TRUE(queue.submit(good_scene()));
  EXPECT_EQ(base.filename(), "two");
}

TEST(Queue, RefusesARootThatIsNoFolder) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.roots = {folder.path / "missing"};
  EXPECT_THROW(Queue(settings, engine_of([](const auto&, const auto&) { return finished(); })),
               Error);
}

}  // namespace
