#include "engine/scene/ball_files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class FilesOfBalls : public SceneTest {
 protected:
  static void write(const std::string& text) {
    std::ofstream(folder() / "balls.csv", std::ios::binary) << text;
  }
  static json scene(json tree) {
    json scene = minimal();
    scene["operations"] = {{{"op", "union"}, {"tree", std::move(tree)}}};
    return scene;
  }
  static json spheres() { return {{"type", "spheres"}, {"falloff", 3}, {"file", "balls.csv"}}; }
  /// What is wrong with a file of this text.
  static std::vector<std::string> wrong(const std::string& text) {
    write(text);
    return texts(problems(scene(spheres())));
  }
};

TEST_F(FilesOfBalls, AreTheSameAsTheBallsInTheScene) {
  write("x,y,z,radius,energy\n100,200,80.5,6,1\r\n\n 150 , 200,90,0.1,-0.5\n");
  json list = spheres();
  list.erase("file");
  list["balls"] = {{100, 200, 80.5, 6, 1}, {150, 200, 90, 0.1, -0.5}};
  const auto file = opened(scene(spheres())), stated = opened(scene(list));
  EXPECT_EQ(file.ground.steps.at(0).tree, stated.ground.steps.at(0).tree);
  EXPECT_EQ(tree::to_json(file.ground), tree::to_json(stated.ground));
}

TEST_F(FilesOfBalls, StayOnDiskWhenTheyAreLarge) {
  std::string text = "x,y,z,radius\n";
  for (int i = 0; i < 3000; ++i) text += fmt::format("{},{},100,2\n", i % 60 * 10, i / 60 * 10);
  write(text);
  OpenSettings small{.cache = folder() / "cache", .ingest = {}};
  small.ball_memory = 1000;
  const auto disk = open(scene(spheres()), sources(), small), memory = opened(scene(spheres()));
  const auto balls_of = [](const Scene& scene) {
    return std::get<tree::SphereSet>(scene.ground.steps.at(0).tree.value).balls;
  };
  EXPECT_TRUE(balls_of(disk).in_file());
  EXPECT_FALSE(balls_of(memory).in_file());
  EXPECT_EQ(balls_of(disk), balls_of(memory));
  EXPECT_EQ(disk.ball_files.size(), 2U);  // and its lock
  EXPECT_EQ(disk.extent.min.z, memory.extent.min.z);
  EXPECT_EQ(disk.extent.max.z, memory.extent.max.z);
}

TEST_F(FilesOfBalls, AreRefusedByRowColumnAndValue) {
  const std::string head = "x,y,z,radius\n";
  EXPECT_THAT(wrong(head + "1,2,3,4\n1,2,3,-1\n"),
              ElementsAre("/operations/0/tree/file: \"balls.csv\": row 3, column radius: must be "
                          "in (0, 100000] m, got -1"));
  EXPECT_THAT(wrong(head + "1,two,3,4\n"),
              ElementsAre(HasSubstr("row 2, column y: must be a number, got two")));
  EXPECT_THAT(wrong(head + "1,2,nan,4\n"), ElementsAre(HasSubstr("row 2, column z")));
  EXPECT_THAT(wrong(head + "1,2,3\n"), ElementsAre(HasSubstr("row 2 must have 4 columns")));
  EXPECT_THAT(wrong(head + "1,2,3,4,5\n"), ElementsAre(HasSubstr("row 2 must have 4 columns")));
  EXPECT_THAT(wrong("x,y,z,radius,energy\n1,2,3,4,1e9\n"),
              ElementsAre(HasSubstr("row 2, column energy: must be in [-1000, 1000], got 1e9")));
  EXPECT_THAT(wrong("1,2,3,4\n"), ElementsAre(HasSubstr("must begin with the line x,y,z,radius")));
  EXPECT_THAT(wrong(""), ElementsAre(HasSubstr("must begin with")));
  EXPECT_THAT(wrong(head), ElementsAre(HasSubstr("holds no ball")));
  std::string many = head;
  for (int i = 0; i < 100; ++i) many += "x,2,3,4\n";
  EXPECT_EQ(wrong(many).size(), 20U);
}

TEST_F(FilesOfBalls, MustBeThereAndStandAlone) {
  write("x,y,z,radius\n1,2,3,4\n");
  json tree = spheres();
  tree["file"] = "nowhere.csv";
  EXPECT_THAT(texts(problems(scene(tree))), ElementsAre(HasSubstr("no file \"nowhere.csv\"")));
  tree = spheres();
  tree["balls"] = {{1, 2, 3, 4}};
  EXPECT_THAT(places_of(problems(scene(tree))), ElementsAre("/operations/0/tree/file"));
  tree = {{"type", "points"}};
  EXPECT_THAT(places_of(problems(scene(tree))), ElementsAre("/operations/0/tree/balls"));
}

TEST_F(FilesOfBalls, AreHeldToTheRoughnessOfPoints) {
  write("x,y,z,radius\n1,2,3,4\n1,2,3,1\n");
  const json tree = {
      {"type", "points"}, {"file", "balls.csv"}, {"turbulence", {{"amplitude", 2.5}}}};
  EXPECT_THAT(texts(problems(scene(tree))),
              ElementsAre("/operations/0/tree/turbulence/amplitude: must be below the least radius "
                          "/ 0.4542 = 2.20166 m, got 2.5"));
}

}  // namespace
}  // namespace hoodoo::scene
