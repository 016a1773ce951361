#include "engine/dem/source_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/dem/resample.hpp"

namespace hoodoo::dem {
namespace {

RasterInfo raster(const std::string& crs, RasterInfo::Crs kind, std::array<double, 6> transform,
                  std::int64_t width, std::int64_t height) {
  RasterInfo info;
  info.path = "test.tif";
  info.width = width;
  info.height = height;
  info.crs = crs;
  info.kind = kind;
  info.transform = transform;
  return info;
}

struct Found {
  double worst = 0;  // [source pixels]
  std::int64_t asked = 0;
};

// The largest difference between the map and PROJ over the pixels of every so many patches.
Found compare(const RasterInfo& info, const Frame& frame, double pixel, std::int64_t every) {
  const auto grid = recipe(info, frame, pixel, {}).grid;
  SourceMap map(info, frame, grid);
  std::vector<Point> points;
  Found found;
  constexpr std::int64_t side = SourceMap::patch;
  for (std::int64_t row = 0; row * side < grid.height; row += every) {
    for (std::int64_t column = 0; column * side < grid.width; column += every) {
      map.map(column * side, row * side, side, side, points);
      for (int k = 0; k < side * side; k += 7) {
        const auto& p = points[static_cast<std::size_t>(k)];
        const auto q = map.exact(static_cast<double>(column * side + k % side) + 0.5,
                                 static_cast<double>(row * side + k / side) + 0.5);
        if (std::isnan(p.x) && std::isnan(q.x)) continue;
        const auto turn = 360 / info.transform[1];
        const double off = std::abs(p.x - q.x);
        found.worst =
            std::max({found.worst, std::min(off, std::abs(off - turn)), std::abs(p.y - q.y)});
        ++found.asked;
      }
    }
  }
  return found;
}

TEST(SourceMap, IsWithinAHundredthOfAPixelOfProjForADegreeOfArcSeconds) {
  constexpr double s = 1 / 3600.0;
  const auto info =
      raster("EPSG:4326", RasterInfo::Crs::geographic, {-125, s, 0, 49, 0, -s}, 3600, 3600);
  const auto found = compare(info, {"EPSG:32610", 1, 350796, 5316757}, 20.5, 3);
  EXPECT_GT(found.asked, 100'000);
  EXPECT_LT(found.worst, 0.01);
  // Rounding alone gives 2^-9 at a corner; between corners less than 1.56 times that.
  EXPECT_LT(found.worst, 1.5625 / 512 + 1e-4);
}

TEST(SourceMap, IsWithinAHundredthOfAPixelOfProjForAKilometreGridOfTenDegrees) {
  constexpr double s = 1 / 120.0;
  const auto info =
      raster("EPSG:4326", RasterInfo::Crs::geographic, {5, s, 0, 52, 0, -s}, 1200, 1200);
  EXPECT_LT(compare(info, {"EPSG:32632", 1, 0, 4600000}, 600, 2).worst, 0.01);
}

TEST(SourceMap, IsWithinAHundredthOfAPixelOfProjForWebMercatorAndLambert) {
  const auto web = raster("EPSG:3857", RasterInfo::Crs::web_mercator,
                          {900000, 30, 0, 5900000, 0, -30}, 1000, 1000);
  EXPECT_LT(compare(web, {"EPSG:32632", 1, 430000, 5100000}, 20, 1).worst, 0.01);
  const auto lambert =
      raster("EPSG:2154", RasterInfo::Crs::projected, {700000, 25, 0, 6400000, 0, -25}, 1000, 1000);
  EXPECT_LT(compare(lambert, {"EPSG:32631", 1, 500000, 4900000}, 25, 1).worst, 0.01);
}

TEST(SourceMap, IsWithinAHundredthOfAPixelOfProjAcrossTheDateLineAndAroundAPole) {
  constexpr double s = 0.01;
  const auto fiji =
      raster("EPSG:4326", RasterInfo::Crs::geographic, {178, s, 0, -16, 0, -s}, 400, 300);
  EXPECT_LT(compare(fiji, {"EPSG:32760", 1, 800000, 7800000}, 1000, 1).worst, 0.01);
  const auto pole =
      raster("EPSG:4326", RasterInfo::Crs::geographic, {-180, 0.1, 0, 90, 0, -0.1}, 3600, 50);
  EXPECT_LT(compare(pole, {"EPSG:5041", 1, 1400000, 1400000}, 2000, 1).worst, 0.01);
}

TEST(SourceMap, DoesNotDependOnWhatWasAskedBefore) {
  constexpr double s = 1 / 3600.0;
  const auto info =
      raster("EPSG:4326", RasterInfo::Crs::geographic, {8, s, 0, 47, 0, -s}, 600, 600);
  const Frame frame{"EPSG:32632", 1, 420000, 5180000};
  const auto grid = recipe(info, frame, 20, {}).grid;
  SourceMap one(info, frame, grid), other(info, frame, grid);
  std::vector<Point> whole, part;
  other.map(0, 0, 64, 64, part);
  other.map(192, 64, 64, 64, part);
  one.map(128, 64, 64, 64, whole);
  other.map(150, 70, 5, 9, part);
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 5; ++i) {
      const auto& a = whole[static_cast<std::size_t>((6 + j) * 64 + 22 + i)];
      const auto& b = part[static_cast<std::size_t>(5 * j + i)];
      EXPECT_EQ(a.x, b.x);
      EXPECT_EQ(a.y, b.y);
    }
  }
}

}  // namespace
}  // namespace hoodoo::dem
