#include "engine/scene/sample.hpp"

#include <gtest/gtest.h>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/base/hash.hpp"
#include "engine/dem/raster.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

TEST(SampleDem, IsReadBackAsItWasMade) {
  const Folder folder;
  const SampleDem sample{300, 4, 1};
  write_sample_dem(folder / "dem.tif", sample);
  const auto raster = dem::Raster::open(folder / "dem.tif");
  EXPECT_EQ(raster->info().width, 300);
  EXPECT_EQ(raster->info().crs, "EPSG:32612");
  EXPECT_EQ(raster->info().transform[1], 4);
  EXPECT_EQ(raster->info().transform[5], -4);
  std::vector<double> pixels;
  raster->read(0, 0, 300, 300, pixels);
  for (const int row : {0, 40, 299}) {
    const auto made = sample_row(sample, 299 - row);
    for (std::size_t i = 0; i < 300; ++i) {
      ASSERT_EQ(pixels[static_cast<std::size_t>(row) * 300 + i], static_cast<float>(made[i]));
    }
  }
}

TEST(SampleDem, HasTheSameBytesEveryTime) {
  const Folder folder;
  write_sample_dem(folder / "a.tif", {});
  write_sample_dem(folder / "b.tif", {});
  EXPECT_EQ(sha256(read_file(folder / "a.tif", 1 << 24)),
            sha256(read_file(folder / "b.tif", 1 << 24)));
}

TEST(SampleDem, HasSeaCliffPlateauAndValleyWhereTheExampleExpectsThem) {
  const SampleDem sample;
  const auto at = [&](double x, double y) {
    return sample_row(sample, static_cast<int>(y / 2))[static_cast<std::size_t>(x / 2)];
  };
  EXPECT_LT(at(150, 500), -8);  // sea bed
  EXPECT_GT(at(600, 400), 80);  // plateau
  EXPECT_GT(at(230, 305), 60);  // headland
  EXPECT_LT(at(126, 290), -8);  // the gap before the stack
  EXPECT_GT(at(60, 284), 45);   // stack
  double lowest = 1000;
  for (int y = 600; y < 860; ++y) lowest = std::min(lowest, at(700, y));
  EXPECT_LT(lowest, 40);  // valley floor
}

TEST(SampleDem, LeavesNothingBehindWhenItCannotBeWritten) {
  const Folder folder;
  EXPECT_THROW(write_sample_dem("/dev/null/dem.tif", {16, 1, 1}), Error);
  EXPECT_THROW(write_sample_dem(folder / "dem.tif", {0, 1, 1}), Error);
  EXPECT_THROW(write_sample_dem(folder / "dem.tif", {16, -1, 1}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace hoodoo::scene
