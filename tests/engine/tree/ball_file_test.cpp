#include "engine/tree/ball_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "engine/base/error.hpp"
#include "engine/base/random.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/reach.hpp"

namespace hoodoo::tree {
namespace {

namespace fs = std::filesystem;

class BallFiles : public testing::Test {
 protected:
  BallFiles() : path_(fs::temp_directory_path() / ("hoodoo-balls-" + std::to_string(::getpid()))) {}
  ~BallFiles() override { fs::remove(path_); }

  /// Over 2 km, one in a hundred of them large and far away.
  static std::vector<Ball> many(std::size_t count) {
    std::vector<Ball> list;
    const auto share = [](std::size_t i, std::int64_t k) {
      return static_cast<double>(random_bits(7, static_cast<std::int64_t>(i), k) >> 11) / 0x1p53;
    };
    for (std::size_t i = 0; i < count; ++i) {
      const double far = i % 100 == 0 ? 10 : 1;
      list.push_back({{2000 * far * share(i, 0), 2000 * share(i, 1), 60 * share(i, 2)},
                      far * (0.5 + share(i, 3)),
                      i % 3 == 0 ? -0.5F : 1.0F});
    }
    return list;
  }

  /// The list by a file that is sorted in runs of a thousand.
  Balls in_file(const std::vector<Ball>& list) const {
    BallFileWriter writer(path_, 1);
    for (const Ball& ball : list) writer.add(ball);
    writer.finish();
    return Balls(std::make_shared<const BallFile>(path_));
  }

  fs::path path_;
};

TEST_F(BallFiles, HoldTheListAndItsDigest) {
  const auto list = many(10'000);
  const Balls file = in_file(list), memory(list);
  EXPECT_TRUE(file.in_file());
  EXPECT_EQ(file.size(), list.size());
  EXPECT_EQ(file.list(), list);
  EXPECT_EQ(file.digest(), memory.digest());
  EXPECT_EQ(file, memory);
  EXPECT_NE(file.digest(), Balls(many(9'999)).digest());
  EXPECT_EQ(file.box(1.5).min, memory.box(1.5).min);
  EXPECT_EQ(file.box(1.5).max, memory.box(1.5).max);
}

TEST_F(BallFiles, LeaveNothingBesideThem) {
  in_file(many(3'000));
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(path_.parent_path())) {
    const auto name = entry.path().filename().string();
    if (name.starts_with(path_.filename().string())) names.insert(name);
  }
  EXPECT_EQ(names, std::set{path_.filename().string()});
}

TEST_F(BallFiles, ArePrunedToTheSameTreesAsListsInMemory) {
  const auto list = many(10'000);
  PointSet points;
  points.balls = Balls(list);
  SphereSet spheres;
  spheres.balls = points.balls;
  const Balls file = in_file(list);
  const auto compare = [&](auto set) {
    const Node memory{set, {}};
    set.balls = file;
    const Node disk{set, {}};
    EXPECT_EQ(support(disk).influence.min, support(memory).influence.min);
    EXPECT_EQ(support(disk).influence.max, support(memory).influence.max);
    for (const double x : {-100.0, 0.0, 300.0, 1990.0, 15'000.0, 40'000.0}) {
      for (const double thinnest : {0.0, 1.0, 4.0, 100.0}) {
        const Box reach{{x, 100, -Box::infinity}, {x + 150, 260, Box::infinity}};
        EXPECT_EQ(prune(disk, reach, thinnest), prune(memory, reach, thinnest)) << x;
        EXPECT_EQ(reach_over(disk, reach).z, reach_over(memory, reach).z) << x;
      }
    }
  };
  compare(points);
  compare(spheres);
}

TEST_F(BallFiles, AreReadByCellsInReachAlone) {
  const auto list = many(20'000);
  in_file(list);
  const BallFile file(path_);
  const Box corner{{0, 0, -Box::infinity}, {100, 100, Box::infinity}};
  const auto found = file.near(corner, 1, 0, 0);
  EXPECT_GT(found.size(), 20U);
  EXPECT_LT(found.size(), 200U);
  EXPECT_TRUE(std::ranges::is_sorted(found, {}, &Balls::Stored::place));
  for (const auto& ball : file.near(corner, 1, 0, 5)) EXPECT_GE(ball.radius, 5);
}

TEST_F(BallFiles, AreRefusedWhenDamaged) {
  in_file(many(2'000));
  fs::resize_file(path_, fs::file_size(path_) - 8);
  EXPECT_THROW(BallFile{path_}, Error);
  std::ofstream(path_) << "short";
  EXPECT_THROW(BallFile{path_}, Error);
}

}  // namespace
}  // namespace hoodoo::tree
