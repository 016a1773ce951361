#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/base/error.hpp"
#include "engine/dem/raster.hpp"
#include "engine/hydrology/percentiles.hpp"
#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

namespace fs = std::filesystem;

fs::path dems() {
  const char* data = std::getenv("HOODOO_TEST_DATA");
  return data == nullptr ? fs::path() : fs::path(data) / "dem";
}

TEST(Files, ARasterComesBackInItsPlace) {
  if (!fs::is_directory(dems())) GTEST_SKIP() << "no test data";
  const auto out = fs::temp_directory_path() / ("hoodoo-hydrology-" + std::to_string(getpid()));
  for (const auto& entry : fs::directory_iterator(dems())) {
    if (entry.path().extension() != ".tif" || fs::file_size(entry) > 4 << 20) continue;
    const Grid grid = read(entry.path());
    const auto file = out / "out.tif";
    write(file, entry.path(), grid, grid.z);
    const auto source = dem::Raster::open(entry.path())->info();
    const auto copy = dem::Raster::open(file);
    const auto& info = copy->info();
    EXPECT_EQ(info.transform, source.transform) << entry.path();
    EXPECT_EQ(info.crs, source.crs) << entry.path();
    EXPECT_EQ(info.layout, "tiled 256 x 256");
    EXPECT_EQ(info.compression, "deflate");
    std::vector<double> row;
    for (std::int32_t j = 0; j < grid.height; j += 7) {
      copy->read(0, j, grid.width, 1, row);
      for (std::int32_t i = 0; i < grid.width; ++i) {
        const auto z = static_cast<double>(grid.z[grid.index(i, j)]);
        const double back = row[static_cast<std::size_t>(i)];
        ASSERT_TRUE(z == back || (std::isnan(z) && std::isnan(back))) << entry.path();
      }
    }
  }
  fs::remove_all(out);
}

TEST(Files, ADegreeHasItsLengthOnTheEllipsoid) {
  const auto file = dems() / "alps_N46E008_90m_epsg4326_i16_voids.tif";
  if (!fs::exists(file)) GTEST_SKIP() << "no test data";
  const auto info = dem::Raster::open(file)->info();
  if (info.kind != dem::RasterInfo::Crs::geographic) GTEST_SKIP() << "another CRS";
  const Grid grid = read(file);
  // At 46.5 degrees a degree of longitude is 76,740 m, one of latitude 111,160 m (tables).
  const auto middle = static_cast<std::size_t>(grid.height) / 2;
  EXPECT_NEAR(grid.dx[middle] / std::abs(info.transform[1]), 76'740, 1'500);
  EXPECT_NEAR(grid.dy[middle] / std::abs(info.transform[5]), 111'160, 60);
  EXPECT_LT(grid.dx.front(), grid.dx.back()) << "rows go south, where degrees are longer";
}

TEST(Percentiles, AreThoseOfTheSortedValues) {
  const auto file = dems() / "seacliff_aoi4_1m_utm10n_f32_nodata.tif";
  if (!fs::exists(file)) GTEST_SKIP() << "no test data";
  Grid grid = read(file);
  for (auto& z : grid.z) z -= 20;  // of both signs
  const auto out = fs::temp_directory_path() / ("hoodoo-percentiles-" + std::to_string(getpid()));
  write(out / "out.tif", file, grid, grid.z);
  std::vector<float> sorted;
  for (const float z : grid.z) {
    if (!std::isnan(z)) sorted.push_back(z);
  }
  std::ranges::sort(sorted);
  ASSERT_LT(sorted.front(), 0);
  const std::vector<double> percents{0, 0.001, 1, 50, 50, 90, 99.9, 100};
  const auto found = percentiles(out / "out.tif", percents);
  for (std::size_t n = 0; n < percents.size(); ++n) {
    const double rank = std::ceil(percents[n] * static_cast<double>(sorted.size()) / 100);
    EXPECT_EQ(found[n], sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1]) << percents[n];
  }
  std::ranges::fill(grid.z, hole);
  write(out / "out.tif", file, grid, grid.z);
  EXPECT_TRUE(std::isnan(percentiles(out / "out.tif", percents)[3]));
  fs::remove_all(out);
}

TEST(Files, WhatDoesNotFitIsALimit) {
  const auto file = dems() / "alps_N46E008_90m_epsg4326_i16_voids.tif";
  if (!fs::exists(file)) GTEST_SKIP() << "no test data";
  try {
    read(file, {1 << 20});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
  }
}

}  // namespace
}  // namespace hoodoo::hydrology
