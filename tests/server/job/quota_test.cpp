#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <limits>
#include <nlohmann/json.hpp>

#include "server/job/queue.hpp"
#include "tests/server/queue_engine.hpp"
#include "tests/server/temporary_folder.hpp"

using namespace hoodoo;
using job::Queue;
using job::Status;
using Kind = job::Submitted::Kind;

namespace {

job::Request of(const std::string& owner) {
  auto request = bake_of(good_scene());
  request.owner = owner;
  return request;
}

TEST(Quota, CountsJobsThatWaitAndRun) {
  const TemporaryFolder folder;
  Queue queue(settings_in(folder), engine_of(until_stopped));
  auto request = of("ann");
  request.quota.jobs = 2;
  const auto first = queue.submit(request).job.id;
  wait_for(queue, first, Status::running);
  EXPECT_EQ(queue.submit(request).kind, Kind::taken);
  const auto refused = queue.submit(request);
  EXPECT_EQ(refused.kind, Kind::owner_full);
  EXPECT_EQ(refused.used, 2U);
  EXPECT_EQ(refused.most, 2U);
  EXPECT_EQ(queue.submit(of("bob")).kind, Kind::taken);
  queue.dismiss(first);
  EXPECT_EQ(queue.submit(request).kind, Kind::taken);
}

TEST(Quota, CountsWhatJobsLeaveOnTheDiskUntilTheyAreRemoved) {
  const TemporaryFolder folder;
  const auto run = [](const job::Work& work) {
    std::filesystem::create_directories(work.folder / "out");
    std::ofstream(work.folder / "out/tileset.json") << std::string(5000, ' ');
    return finished();
  };
  std::optional<Queue> queue;
  queue.emplace(settings_in(folder), engine_of(run));
  auto request = of("ann");
  request.quota.bytes = 5000;
  const auto id = queue->submit(request).job.id;
  wait_for(*queue, id, Status::successful);
  for (int i = 0; i < 1000 && queue->bytes_of("ann") == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(queue->bytes_of("ann"), 5000U);
  EXPECT_EQ(queue->bytes_of("bob"), 0U);
  const auto refused = queue->submit(request);
  EXPECT_EQ(refused.kind, Kind::owner_space);
  EXPECT_EQ(refused.used, queue->bytes_of("ann"));
  queue.reset();
  queue.emplace(settings_in(folder), engine_of(run));
  EXPECT_EQ(queue->submit(request).kind, Kind::owner_space) << "after a restart";
  queue->dismiss(id);
  EXPECT_EQ(queue->bytes_of("ann"), 0U);
  EXPECT_EQ(queue->submit(request).kind, Kind::taken);
}

TEST(Quota, OfABakeGoesWithItsJob) {
  const TemporaryFolder folder;
  auto request = of("ann");
  request.quota.bake = {7, 250.5};
  {
    Queue queue(settings_in(folder), engine_of(until_stopped));
    queue.submit(request);
  }
  std::promise<job::Bounds> seen;
  Queue queue(settings_in(folder), engine_of([&](const job::Work& work) {
                seen.set_value(work.bounds);
                return finished();
              }));
  const auto bounds = seen.get_future().get();
  EXPECT_EQ(bounds.tiles, 7U);
  EXPECT_EQ(bounds.extent, 250.5);
}

TEST(Queue, TakesNoJobsOnAFullDisk) {
  const TemporaryFolder folder;
  auto settings = settings_in(folder);
  settings.free_space = std::numeric_limits<std::uint64_t>::max();
  Queue queue(settings, engine_of(until_stopped));
  try {
    queue.submit(of("ann"));
    FAIL() << "took a job";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::io);
  }
}

TEST(UsedAsset, StaysWhileAJobNeedsIt) {
  const TemporaryFolder folder;
  const std::string name = "sha256-" + std::string(64, 'a');
  std::atomic<bool> open = false;
  Queue queue(settings_in(folder), engine_of([&](const auto&) {
                while (!open) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                return finished();
              }));
  queue.add_asset(name, "ann", 100);
  EXPECT_EQ(queue.owner_of(name), "ann");
  EXPECT_EQ(queue.bytes_of("ann"), 100U);
  auto request = of("bob");
  request.inputs["scene"]["terrains"] = nlohmann::json::array({{{"dem", "./" + name}}});
  const auto running = queue.submit(request).job.id, waiting = queue.submit(request).job.id;
  wait_for(queue, running, Status::running);
  int removed = 0;
  const auto release = [&](std::optional<job::Time> since) {
    return queue.release(name, since, [&] { ++removed; });
  };
  EXPECT_FALSE(release({}));
  const auto before = job::now();
  open = true;
  wait_for(queue, waiting, Status::successful);
  EXPECT_FALSE(release(before)) << "a job has just used it";
  EXPECT_EQ(removed, 0);
  EXPECT_TRUE(release(job::now() + std::chrono::hours(1)));
  EXPECT_EQ(removed, 1);
  EXPECT_EQ(queue.bytes_of("ann"), 0U);
  EXPECT_FALSE(queue.owner_of(name));
}

TEST(UsedAsset, IsKnownAfterARestartAndForgottenOnceItsFileIsGone) {
  const TemporaryFolder folder;
  const std::string here = "sha256-" + std::string(64, 'a'),
                    gone = "sha256-" + std::string(64, 'b');
  folder.write("data/assets/" + here, "abc");
  {
    Queue queue(settings_in(folder), engine_of(until_stopped));
    queue.add_asset(gone, "ann", 100);
    EXPECT_EQ(queue.owner_of(here), "") << "nobody's";
  }
  const Queue queue(settings_in(folder), engine_of(until_stopped));
  EXPECT_FALSE(queue.owner_of(gone));
  EXPECT_EQ(queue.bytes_of("ann"), 0U);
}

}  // namespace
