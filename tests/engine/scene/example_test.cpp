#include <gmock/gmock.h>

#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using testing::IsEmpty;

/// The bundled scene on the DEM that it names, as `hoodoo synthesize` makes it.
class Example : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Folder folder;
    write_sample_dem(folder / "dem.tif", {});
    const auto stated = read(HOODOO_SCHEMA_DIR "/examples/first-light/scene.json");
    std::vector<Problem> warnings;
    EXPECT_THAT(texts(check(stated, {folder.path(), {}}, &warnings)), IsEmpty());
    EXPECT_THAT(texts(warnings), IsEmpty());
    scene_ =
        new Scene(open(stated, {folder.path(), {}}, {.cache = folder / "cache", .ingest = {}}));
  }
  static void TearDownTestSuite() {
    delete scene_;
    scene_ = nullptr;
  }
  static bool solid(double x, double y, double z) { return field(*scene_, {x, y, z}) > 0.5F; }

  static inline Scene* scene_ = nullptr;
};

TEST_F(Example, HasNoOddities) { EXPECT_THAT(scene_->warnings, IsEmpty()); }

TEST_F(Example, HasAnArchWithAFreeSpan) {
  EXPECT_TRUE(solid(118, 295, 64));
  EXPECT_FALSE(solid(118, 295, 84));
  for (double z = -8; z < 46; z += 6) EXPECT_FALSE(solid(118, 295, z)) << z;
  EXPECT_TRUE(solid(176, 306, 44));  // its feet stand in rock
  EXPECT_TRUE(solid(60, 284, 40));
}

TEST_F(Example, HasATunnelRightThroughTheHeadland) {
  for (double y = 236; y <= 372; y += 4) EXPECT_FALSE(solid(246, y, 12)) << y;
  EXPECT_TRUE(solid(246, 300, 40));
  EXPECT_TRUE(solid(220, 300, 12));
  EXPECT_TRUE(solid(272, 300, 12));
}

TEST_F(Example, HasACaveInTheFootOfTheCliff) {
  EXPECT_FALSE(solid(316, 518, 14));
  EXPECT_FALSE(solid(350, 523, 14));
  EXPECT_FALSE(solid(408, 531, 18));
  EXPECT_TRUE(solid(370, 526, 60));  // rock over it
  EXPECT_TRUE(solid(460, 538, 18));  // rock behind it
}

TEST_F(Example, HasAnOverhangAlongTheCliff) {
  for (double y = 400; y <= 450; y += 10) {
    bool overhang = false;
    for (double x = 310; x < 350; x += 2) overhang |= !solid(x, y, 14) && solid(x, y, 60);
    EXPECT_TRUE(overhang) << y;
  }
}

TEST_F(Example, HasALedgeOverTheSea) {
  const double top =
      scene_->pyramids[0]->window(0, Box{{368, 200, 0}, {368, 200, 0}}).height(368, 200);
  EXPECT_TRUE(solid(336, 200, top - 12));
  for (double z = 4; z < top - 28; z += 6) EXPECT_FALSE(solid(334, 200, z)) << z;
}

/// Every folder of schema/examples with a scene.
std::vector<std::filesystem::path> examples() {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(HOODOO_SCHEMA_DIR "/examples")) {
    if (std::filesystem::exists(entry.path() / "scene.json")) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(Examples, AreReadWithoutAProblemOrAnOddity) {
  const auto all = examples();
  EXPECT_GE(all.size(), 8U);
  for (const auto& example : all) {
    SCOPED_TRACE(example.filename());
    const Folder folder;
    // One without elevations of its own stands on the sample.
    if (std::filesystem::exists(example / "dem.tif")) {
      std::filesystem::copy_file(example / "dem.tif", folder / "dem.tif");
    } else {
      write_sample_dem(folder / "dem.tif", {});
    }
    const Sources sources{folder.path(), {}};
    const auto stated = read(example / "scene.json");
    std::vector<Problem> warnings;
    EXPECT_THAT(texts(check(stated, sources, &warnings)), IsEmpty());
    EXPECT_THAT(texts(warnings), IsEmpty());
    const auto scene = open(stated, sources, {.cache = folder / "cache", .ingest = {}});
    EXPECT_THAT(scene.warnings, IsEmpty());
    EXPECT_FALSE(scene.name.empty());
  }
}

}  // namespace
}  // namespace hoodoo::scene
