#include <gmock/gmock.h>

#include <cmath>

#include "tests/engine/scene/growing.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;

/// A slab 2 m thick and 40 m wide stands high over the sample coast, on a ball; all is smoothed
/// within a box around it.
class Smoothing : public GrowingTest {
 protected:
  static json shapes() {
    auto scene = minimal();
    scene["bake"]["spacing"] = 1;
    scene["bake"]["extent"] = {{"min", {440, 440}}, {"max", {560, 560}}};
    scene["operations"] = json::parse(R"([
      {"op": "union", "tree": {"type": "sphere", "center": [500, 500, 200], "radius": 14}},
      {"op": "union", "tree": {"type": "box", "center": [500, 500, 230], "size": [40, 40, 2],
                               "falloff": 2}}])");
    return scene;
  }
  static json smoothed(const json& more = json::object(), double feather = 4) {
    auto scene = shapes();
    json smooth = {{"id", "s"},
                   {"type", "smooth"},
                   {"size", 6},
                   {"region",
                    {{"type", "box"},
                     {"min", {470, 470, 170}},
                     {"max", {530, 530, 245}},
                     {"feather", feather}}}};
    smooth.update(more);
    scene["operations"].push_back(std::move(smooth));
    return scene;
  }
  static const tree::VoxelGrid& voxels(const Scene& scene) {
    return std::get<tree::VoxelGrid>(scene.ground.steps.back().tree.value);
  }
};

TEST_F(Smoothing, TakesWhatIsThinAndKeepsWhatIsThick) {
  const auto before = grown(shapes()), after = grown(smoothed());
  // The slab's middle plane: a seventh of the kernel's width is solid.
  for (const double x : {485.0, 500.0, 515.0}) {
    EXPECT_GT(field(before, {x, 500, 230}), 0.5F);
    EXPECT_LT(field(after, {x, 500, 230}), 0.5F);
  }
  // The ball: a sphere of 14 m loses about sigma^2 / r, sigma = size / 3 and a little by voxels.
  const auto radius = [&](const Scene& scene) {
    double low = 5, high = 20;
    for (int i = 0; i < 30; ++i) {
      const double r = (low + high) / 2;
      (field(scene, {500 + r * 0.6, 500, 200 + r * 0.8}) > 0.5F ? low : high) = r;
    }
    return low;
  };
  EXPECT_NEAR(radius(before), 14, 0.01);
  EXPECT_LT(radius(after), 13.9);
  EXPECT_GT(radius(after), 13.3);
  EXPECT_EQ(field(after, {500, 500, 200}), 1.0F);
}

TEST_F(Smoothing, IsTheWeightedMeanOfTheSceneSoFar) {
  const auto before = grown(shapes()), after = grown(smoothed({{"size", 3}}));
  const auto& grid = voxels(after);
  EXPECT_EQ(grid.voxels.placement().linear[0][0], 1);
  tree::Voxels::Cursor cursor(grid.voxels);
  double sum = 0;
  const auto weight = [](int i) {
    const double q = 1 - i * i / 9.0;
    return q * q * q;
  };
  for (int i = -2; i <= 2; ++i) sum += weight(i);
  for (const auto& at : {tree::Voxel{488, 500, 208}, {510, 505, 229}, {500, 519, 231}}) {
    double mean = 0;
    for (int i = -2; i <= 2; ++i) {
      for (int j = -2; j <= 2; ++j) {
        for (int k = -2; k <= 2; ++k) {
          const Vec3 p{1.0 * (at[0] + i), 1.0 * (at[1] + j), 1.0 * (at[2] + k)};
          mean += weight(i) * weight(j) * weight(k) / (sum * sum * sum) *
                  static_cast<double>(field(before, p));
        }
      }
    }
    EXPECT_GT(mean, 0.01);
    EXPECT_LT(mean, 0.99);
    EXPECT_NEAR(static_cast<double>(cursor.at(at[0], at[1], at[2])), mean, 1e-5);
  }
}

TEST_F(Smoothing, ChangesNothingOutsideItsRegion) {
  const auto before = grown(shapes()), after = grown(smoothed(json::object(), 0));
  std::size_t changed = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p{450 + 5.3 * (i % 19), 450 + 4.9 * (i / 19 % 21), 60 + 43.7 * (i / 399)};
    const bool inside = Box{{470, 470, 170}, {530, 530, 245}}.contains(p);
    if (inside) continue;
    EXPECT_EQ(field(after, p), field(before, p)) << i;
  }
  for (int i = 0; i < 500; ++i) {
    const Vec3 p{480 + 1.7 * (i % 23), 485 + 1.3 * (i / 23), 229.3};
    changed += field(after, p) != field(before, p) ? 1 : 0;
  }
  EXPECT_GT(changed, 400U);
}

TEST_F(Smoothing, HasTheSameVoxelsForAnyThreadsAndWhereverRegionsOverlap) {
  const auto one = grown(smoothed(), 1), two = grown(smoothed(), 2);
  EXPECT_EQ(voxels(one).file, voxels(two).file);
  const auto other = grown(smoothed(
      {{"region",
        {{"type", "box"}, {"min", {490, 480, 150}}, {"max", {560, 560, 300}}, {"feather", 4}}}}));
  EXPECT_NE(voxels(one).file, voxels(other).file);
  tree::Voxels::Cursor a(voxels(one).voxels), b(voxels(other).voxels);
  for (std::int32_t x = 495; x < 525; ++x) {
    for (std::int32_t z = 180; z < 240; ++z) ASSERT_EQ(a.at(x, 511, z), b.at(x, 511, z));
  }
}

TEST_F(Smoothing, LeavesTheGroundBelowWhereItIsEven) {
  auto stated = smoothed({{"region",
                           {{"type", "polygon"},
                            {"points", {{460, 460}, {540, 460}, {540, 540}, {460, 540}}},
                            {"feather", 6}}}});
  const auto before = grown(shapes()), after = grown(stated);
  for (int i = 0; i < 100; ++i) {
    const double x = 465.0 + 7 * (i % 10), y = 465.0 + 7 * (i / 10);
    const double h = before.pyramids[0]->window(0, Box{{x, y, 0}, {x, y, 0}}).height(x, y);
    EXPECT_GT(field(after, {x, y, h - 0.5}), 0.5F) << i;
    EXPECT_LT(field(after, {x, y, h + 0.5}), 0.5F) << i;
    EXPECT_GT(field(after, {x, y, h - 60}), 0.5F) << i;
  }
}

TEST_F(Smoothing, KeepsTheGroundUpToTheEdgeOfTheWorld) {
  auto stated = smoothed();
  stated["operations"].back().erase("region");
  const auto after = grown(stated);
  for (const double x : {440.25, 441.0, 443.0, 559.75}) {
    const double h = after.pyramids[0]->window(0, Box{{x, 500, 0}, {x, 500, 0}}).height(x, 500);
    EXPECT_GT(field(after, {x, 500, h - 0.7}), 0.5F) << x;
    EXPECT_LT(field(after, {x, 500, h + 0.7}), 0.5F) << x;
  }
}

TEST_F(Smoothing, TakesCoarserStepsWhereItIsWide) {
  EXPECT_EQ(voxels(grown(smoothed({{"size", 8}}))).voxels.placement().linear[0][0], 1);
  EXPECT_EQ(voxels(grown(smoothed({{"size", 20}}))).voxels.placement().linear[0][0], 4);
}

TEST_F(Smoothing, NamesWhatIsWrong) {
  EXPECT_THAT(texts(problems(smoothed({{"size", -1}}))),
              ElementsAre("/operations/2/size: must be in (0, 1000] m, got -1"));
  const auto failure = [](const json& scene, std::size_t memory) {
    OpenSettings settings{.cache = folder() / "cache", .ingest = {}};
    settings.ingest.memory = memory;
    try {
      open(scene, sources(), settings);
    } catch (const Error& error) {
      return std::pair(error.fault, texts(error.problems).at(0));
    }
    return std::pair(Fault::internal, std::string());
  };
  EXPECT_EQ(
      failure(smoothed({{"size", 1.5}}), std::size_t{256} << 20),
      std::pair(Fault::bad_input,
                std::string("/operations/2/size: must be at least two spacings, 2 m, got 1.5")));
  EXPECT_EQ(failure(smoothed(), std::size_t{1} << 20),
            std::pair(Fault::limit,
                      std::string("/operations/2: smooths more than the memory holds: make the "
                                  "region smaller or \"size\" larger, or give more memory")));
}

}  // namespace
}  // namespace hoodoo::scene
