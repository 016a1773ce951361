#include "engine/scene/picture.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"

using namespace hoodoo;
using nlohmann::json;
using scene::Picture;
using tree::Family;

namespace {

constexpr int size = 200;

std::array<int, 3> pixel(const Picture& picture, int i, int j) {
  const auto at = static_cast<std::size_t>(3 * (j * picture.size + i));
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

/// Pixels that show anything but the paper of the upper left corner.
int covered(const Picture& picture) {
  int count = 0;
  for (int j = 0; j < picture.size; ++j) {
    for (int i = 0; i < picture.size; ++i) {
      count += pixel(picture, i, j) != pixel(picture, 0, 0) ? 1 : 0;
    }
  }
  return count;
}

Picture drawn(const json& tree, Family family = Family::terrain) {
  return scene::draw(scene::read_tree(tree, family), family, size);
}

}  // namespace

TEST(Draw, ShowsASphereAsADiskOfItsSize) {
  // The influence reaches 0.5458 falloffs beyond the surface; the picture shows 2 x 1.75 half
  // cubes.
  const double radius = 8, falloff = 4;
  const double half = 0.51 * 2 * (radius + 0.5458 * falloff);
  const double pixels = radius / (3.5 * half) * size;
  const auto picture =
      drawn({{"type", "sphere"}, {"center", {3, 4, 5}}, {"radius", radius}, {"falloff", falloff}});
  EXPECT_NEAR(covered(picture), std::numbers::pi * pixels * pixels, 0.03 * covered(picture));
  EXPECT_NE(pixel(picture, size / 2, size / 2), pixel(picture, 0, 0)) << "it is in the middle";
}

TEST(Draw, ShowsLayersOnTwoSidesOfACubeAndOneOnTop) {
  const auto picture = drawn({{"type", "strata"}, {"wavelength", 6}}, Family::geology);
  std::set<std::array<int, 3>> down, across;
  for (int k = 0; k < 40; ++k) {
    down.insert(pixel(picture, size / 2 - 20, size / 2 + k));
    across.insert(pixel(picture, size / 2 - 20 + k, size / 4));
  }
  EXPECT_GT(down.size(), 10U);
  EXPECT_EQ(across.size(), 1U);
}

TEST(Draw, LeavesThePaperEmptyWhereNothingIs) {
  EXPECT_EQ(covered(drawn({{"type", "blend"}, {"children", json::array()}})), 0);
}

TEST(Png, IsTheSameInMemoryAndInAFile) {
  const auto picture = drawn({{"type", "blend"}, {"children", json::array()}});
  const auto file = std::filesystem::temp_directory_path() /
                    ("hoodoo-png-test-" + std::to_string(::getpid()) + ".png");
  scene::write_png(picture, file);
  const auto there = read_file(file, 1U << 24);
  std::filesystem::remove(file);
  const auto bytes = scene::png(picture);
  EXPECT_EQ(there, std::string(bytes.begin(), bytes.end()));
  EXPECT_EQ(there.substr(0, 8), "\x89PNG\r\n\x1a\n");
}

TEST(ReadTree, RefusesWhatNeedsAGround) {
  const json ball = {{"type", "sphere"},
                     {"center", {{"xy", {0, 0}}, {"ground", 2}}},
                     {"radius", 3},
                     {"falloff", 2}};
  try {
    scene::read_tree(ball, Family::terrain);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    EXPECT_NE(std::string(error.what()).find("no ground"), std::string::npos);
  }
}

TEST(ReadTree, TellsOfEveryProblem) {
  try {
    scene::read_tree({{"type", "sphere"}, {"centre", {0, 0, 0}}, {"radius", -1}}, Family::terrain);
    FAIL();
  } catch (const Error& error) {
    EXPECT_GE(error.problems.size(), 3U) << error.what();
  }
}
