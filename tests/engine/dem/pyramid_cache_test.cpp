#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/dem/chunks.hpp"
#include "engine/dem/dem.hpp"
#include "tests/engine/dem/pyramids.hpp"

/// Pyramids that are there already, half made, damaged or made by two at once.
namespace hoodoo::dem {
namespace {

TEST(Pyramid, OpensWhatIsThereAndMakesAnewWhatIsChanged) {
  const ScratchFolder folder;
  const auto path = projected(folder, 100, 100, hills(100, 100));
  const auto first = ingest(path, folder / "cache");
  const auto file = folder / "cache" / first->digest().hex() / "pyramid.json";
  const auto when = std::filesystem::last_write_time(file);
  EXPECT_EQ(ingest(path, folder / "cache")->digest(), first->digest());
  EXPECT_EQ(std::filesystem::last_write_time(file), when);
  auto other = hills(100, 100);
  other[5] += 1;
  EXPECT_NE(ingest(projected(folder, 100, 100, other), folder / "cache")->digest(),
            first->digest());
}

TEST(Pyramid, CancelledLeavesNothingThatWouldBeOpened) {
  const ScratchFolder folder;
  const auto path = projected(folder, 600, 600, hills(600, 600));
  std::stop_source stop;
  IngestSettings settings;
  settings.stop = stop.get_token();
  settings.progress = [&](double done) {
    EXPECT_GE(done, 0);
    EXPECT_LE(done, 1);
    stop.request_stop();
  };
  try {
    ingest(path, folder / "cache", {}, settings);
    FAIL() << "was not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::cancelled);
  }
  EXPECT_TRUE(contents(folder / "cache").empty());
  EXPECT_EQ(ingest(path, folder / "cache")->levels()[0].width, 600);
}

TEST(Pyramid, TwoAtOnceMakeOne) {
  const ScratchFolder folder;
  const auto path = projected(folder, 600, 600, hills(600, 600));
  std::atomic<int> good{0};
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 4; ++k) {
      threads.emplace_back(
          [&] { good += ingest(path, folder / "cache")->levels()[0].width == 600; });
    }
  }
  EXPECT_EQ(good, 4);
}

/// Exclusive-ors one byte of a file.
void flip(const std::filesystem::path& path, std::streamoff at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(at);
  const auto byte = static_cast<char>(file.get() ^ 1);
  file.seekp(at);
  file.put(byte);
}

TEST(Pyramid, RefusesADamagedChunkOnceAndMakesItAnew) {
  const ScratchFolder folder;
  const auto path = projected(folder, 100, 100, hills(100, 100));
  const auto p = ingest(path, folder / "cache");
  const auto whole = contents(folder / "cache");
  flip(level_file(folder / "cache" / p->digest().hex(), 0), 4000);
  const auto damaged = ingest(path, folder / "cache");
  EXPECT_THROW(damaged->window(0, p->extent()), Error);
  const auto anew = ingest(path, folder / "cache");
  EXPECT_FALSE(anew->window(0, p->extent()).empty());
  EXPECT_EQ(contents(folder / "cache"), whole);
}

TEST(Pyramid, MakesOneWithADamagedIndexAnew) {
  const ScratchFolder folder;
  const auto path = projected(folder, 100, 100, hills(100, 100));
  const auto place = folder / "cache" / ingest(path, folder / "cache")->digest().hex();
  const auto whole = contents(folder / "cache");
  const auto text = read_file(index_file(place), 1 << 20);
  // A number that would move the land without making the JSON wrong.
  flip(index_file(place), static_cast<std::streamoff>(text.find("\"dx\": ") + 6));
  ingest(path, folder / "cache");
  EXPECT_EQ(contents(folder / "cache"), whole);
  for (const auto& name : {place / "chunks.bin", level_file(place, 1)}) {
    std::filesystem::remove(name);
    ingest(path, folder / "cache");
    EXPECT_EQ(contents(folder / "cache"), whole) << name;
  }
}

TEST(Pyramid, KeepsNothingOfARasterThatChangesMeanwhile) {
  const ScratchFolder folder;
  auto samples = hills(600, 600);
  const auto path = projected(folder, 600, 600, samples);
  IngestSettings settings;
  bool changed = false;
  settings.progress = [&](double) {
    if (changed) return;
    changed = true;
    for (auto& h : samples) h += 1;
    projected(folder, 600, 600, samples);
  };
  try {
    ingest(path, folder / "cache", {}, settings);
    FAIL() << "did not notice";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::io);
    EXPECT_THAT(error.what(), testing::HasSubstr("projected.tif: changed while it was read"));
  }
  EXPECT_TRUE(contents(folder / "cache").empty());
}

TEST(Pyramid, SaysThatARasterChangedRatherThanWhatCameOfIt) {
  const ScratchFolder folder;
  const auto path = projected(folder, 600, 600, hills(600, 600));
  IngestSettings settings;
  settings.progress = [&](double) { std::filesystem::resize_file(path, 20'000); };
  try {
    ingest(path, folder / "cache", {}, settings);
    FAIL() << "did not notice";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("changed while it was read"));
  }
}

}  // namespace
}  // namespace hoodoo::dem
