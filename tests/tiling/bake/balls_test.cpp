#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/random.hpp"
#include "tests/tiling/bake/folder.hpp"

using namespace hoodoo;
using nlohmann::json;

namespace {

class ManyBalls : public BakeTest {
 protected:
  /// 3,000 balls on the ground; the ball numbered `raised` stands higher.
  json write(int raised) const {
    std::ofstream file(folder_ / "balls.csv");
    file << "x,y,z,radius,energy\n";
    json list = json::array();
    for (int i = 0; i < 3000; ++i) {
      const auto share = [i](std::int64_t k) {
        return static_cast<double>(random_bits(3, i, k) >> 12) / 0x1p52;
      };
      const json ball = {800 * share(0), 800 * share(1),
                         60 + 40 * share(2) + (i == raised ? 30 : 0), 10 + 10 * share(3), 1};
      list.push_back(ball);
      for (std::size_t k = 0; k < 5; ++k) file << (k > 0 ? "," : "") << ball[k].dump();
      file << "\n";
    }
    return list;
  }
  static json with(const json& balls) {
    json all = scene();
    json tree = {{"type", "spheres"}, {"falloff", 8}};
    tree.update(balls);
    all["operations"].push_back({{"op", "union"}, {"tree", tree}});
    return all;
  }
  static bake::Settings memory(std::size_t bytes) {
    bake::Settings settings;
    settings.memory = bytes;
    return settings;
  }
  /// The bake's files but for the balls themselves.
  std::map<std::string, std::string> baked(const std::string& name) const {
    auto found = files(name);
    std::erase_if(found,
                  [](const auto& file) { return file.first.find(".balls") != std::string::npos; });
    return found;
  }
};

}  // namespace

TEST_F(ManyBalls, GiveTheSameBytesFromAListMemoryAndDisk) {
  const json list = write(-1);
  const json file = with({{"file", "balls.csv"}});
  EXPECT_TRUE(run(with({{"balls", list}}), "list").complete);
  EXPECT_TRUE(run(file, "memory", memory(1U << 30)).complete);
  EXPECT_TRUE(run(file, "disk", memory(1U << 20)).complete);
  EXPECT_EQ(files("memory").size(), baked("memory").size());
  EXPECT_EQ(files("disk").size(), baked("disk").size() + 2);  // sorted balls, and their lock
  EXPECT_EQ(baked("memory"), baked("list"));
  EXPECT_EQ(baked("disk"), baked("list"));
}

TEST_F(ManyBalls, AreBakedAgainWhereOneOfAFileChanged) {
  write(-1);
  const json file = with({{"file", "balls.csv"}});
  run(file, "edited", memory(1U << 20));
  write(7);
  const auto edited = run(file, "edited", memory(1U << 20));
  EXPECT_GT(edited.progress.reused, edited.progress.total / 2);
  EXPECT_LT(edited.progress.reused, edited.progress.total);
  run(file, "clean", memory(1U << 20));
  EXPECT_EQ(files("edited"), files("clean"));
}
