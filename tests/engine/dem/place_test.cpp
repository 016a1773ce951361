#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/base/error.hpp"
#include "engine/dem/dem.hpp"
#include "tests/engine/dem/written_tiff.hpp"

namespace hoodoo::dem {
namespace {

std::unique_ptr<Raster> raster(const ScratchFolder& folder, std::vector<double> scale,
                               std::vector<double> ties, std::function<void(GTIF*)> keys,
                               int width = 100, int height = 80) {
  TiffOptions o;
  o.scale = std::move(scale);
  o.ties = std::move(ties);
  o.keys = std::move(keys);
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return Raster::open(
      write_tiff(folder / "dem.tif", width, height, std::vector<float>(count, 1.0f), o));
}

TEST(Spacing, IsAMultipleOfItsStep) {
  EXPECT_EQ(step_of(1), 1.0 / 256);
  EXPECT_EQ(step_of(0.999), 1.0 / 512);
  EXPECT_EQ(step_of(30), 1.0 / 16);
  EXPECT_EQ(rounded_spacing(30), 30);
  EXPECT_EQ(rounded_spacing(1), 1);
  for (const double s : {0.1, 0.37, 7.2, 20.517, 63.98, 92.7, 1023.9}) {
    const double rounded = rounded_spacing(s), step = step_of(s);
    EXPECT_EQ(rounded / step, std::floor(rounded / step));
    EXPECT_LE(std::abs(rounded - s), step / 2);
    EXPECT_GE(rounded / step_of(rounded), 256);
    EXPECT_LE(rounded / step_of(rounded), 512);
  }
}

TEST(Place, KeepsAProjectedCrsAndFloorsTheOriginToTheSpacing) {
  const ScratchFolder folder;
  const auto p = place(*raster(folder, {30, 30, 0}, {0, 0, 0, 500010, 5000000, 0}, utm()), {});
  EXPECT_EQ(p.frame.crs, "EPSG:32632");
  EXPECT_EQ(p.spacing, 30);
  EXPECT_EQ(p.frame.origin_x, 499980 + 30);
  EXPECT_EQ(p.frame.origin_y, std::floor((5000000 - 80 * 30) / 30.0) * 30);
}

TEST(Place, TakesTheGivenSpacingForTheOrigin) {
  const ScratchFolder folder;
  const auto p = place(*raster(folder, {30, 30, 0}, {0, 0, 0, 500010, 5000000, 0}, utm()), 64.0);
  EXPECT_EQ(p.spacing, 64);
  EXPECT_EQ(p.frame.origin_x, std::floor(500010 / 64.0) * 64);
}

TEST(Place, ConvertsFeetToMetres) {
  const ScratchFolder folder;
  const auto p = place(*raster(folder, {10, 10, 0}, {0, 0, 0, 700000, 900000, 0}, utm(2222)), {});
  EXPECT_DOUBLE_EQ(p.frame.unit, 0.3048);
  EXPECT_NEAR(p.spacing, 3.048, step_of(3.048));
  EXPECT_NEAR(p.frame.origin_x, 700000 * 0.3048, p.spacing);
}

TEST(Place, PutsDegreesIntoTheUtmZoneOfTheirCentre) {
  const ScratchFolder folder;
  const auto frame_at = [&](double lon, double lat) {
    return place(*raster(folder, {0.001, 0.001, 0}, {50, 40, 0, lon, lat, 0}, degrees()), {})
        .frame.crs;
  };
  EXPECT_EQ(frame_at(8.5, 46.5), "EPSG:32632");
  EXPECT_EQ(frame_at(-124.5, 48.5), "EPSG:32610");
  EXPECT_EQ(frame_at(-70, -33), "EPSG:32719");
  EXPECT_EQ(frame_at(6, 50), "EPSG:32632");  // on the border of two zones
  EXPECT_EQ(frame_at(179.99, 10), "EPSG:32660");
  EXPECT_EQ(frame_at(-180, 10), "EPSG:32601");
  EXPECT_EQ(frame_at(185, 10), "EPSG:32601");
  EXPECT_EQ(frame_at(15, 85), "EPSG:5041");
  EXPECT_EQ(frame_at(15, -81), "EPSG:5042");
}

TEST(Place, TakesTheSmallerGroundSizeOfAPixelAsSpacing) {
  const ScratchFolder folder;
  const auto p =
      place(*raster(folder, {1 / 3600.0, 1 / 3600.0, 0}, {50, 40, 0, 9, 60, 0}, degrees()), {});
  // At 60 degrees an arc second of longitude is 15.5 m on the ellipsoid; UTM scales by 0.9996.
  EXPECT_NEAR(p.spacing, 15.50 * 0.9996, 0.05);
}

TEST(Place, PutsWebMercatorIntoUtm) {
  const ScratchFolder folder;
  const auto p = place(*raster(folder, {30, 30, 0}, {0, 0, 0, 946000, 5860000, 0}, utm(3857)), {});
  EXPECT_EQ(p.frame.crs, "EPSG:32632");
  EXPECT_NEAR(p.spacing, 30 * std::cos(46.5 * 3.14159265 / 180), 0.3);
}

TEST(Place, IsLocalWithoutACrs) {
  const ScratchFolder folder;
  const auto p = place(*raster(folder, {2, 3, 0}, {0, 0, 0, 100, 200, 0}, nullptr), {});
  EXPECT_EQ(p.frame.crs, "");
  EXPECT_EQ(p.spacing, 2);
  EXPECT_EQ(p.frame.origin_x, 100);
  EXPECT_EQ(p.frame.origin_y, 200 - 80 * 3);
}

TEST(Place, RefusesAWorldThatNoPlaneHolds) {
  const ScratchFolder folder;
  const auto globe = raster(folder, {3.6, 2.25, 0}, {0, 0, 0, -180, 90, 0}, degrees());
  EXPECT_THROW(place(*globe, {}), Error);
  const auto nowhere = raster(folder, {0.1, 0.1, 0}, {0, 0, 0, 5, 400, 0}, degrees());
  EXPECT_THROW(place(*nowhere, {}), Error);
}

}  // namespace
}  // namespace hoodoo::dem
