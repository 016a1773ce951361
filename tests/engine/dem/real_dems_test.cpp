#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/dem/dem.hpp"
#include "tests/engine/dem/written_tiff.hpp"

namespace hoodoo::dem {
namespace {

/// What gdalinfo (GDAL 3.6.2) says of a file.
struct Known {
  const char* file;
  int width, height;
  const char* sample;
  const char* crs;
  double pixel_x, pixel_y;  // units of the CRS
  double nodata_share;      // [%]
  double low, high;         // [m]
};

constexpr Known known[] = {
    {"alps_N46E008_90m_epsg4326_i16_voids", 1201, 1201, "int16", "EPSG:4326", 0.000833333,
     0.000833333, 7.2, 187, 4173},
    {"bigtujunga_30m_utm11n_i16", 1197, 643, "int16", "EPSG:32611", 30, 30, 0, 315, 2295},
    {"cevennes_30m_utm31n_i16", 1654, 1596, "int16", "EPSG:32631", 30, 30, 0, 85, 1672},
    {"dales_N54W003_90m_epsg4326_i16", 1201, 1201, "int16", "EPSG:4326", 0.000833333, 0.000833333,
     0, -2, 891},
    {"fuji_30m_epsg4326_i16_voids", 1712, 1425, "int16", "EPSG:4326", 0.000277778, 0.000277778, 3.3,
     -12, 3759},
    {"greenriver_1m_utm12n_f32", 2000, 1000, "float32", "EPSG:6341", 1, 1, 0, 1297.3, 1347.0},
    {"luxembourg_1km_epsg4326_i16_nodata", 95, 90, "int16", "EPSG:4326", 0.00833333, 0.00833333,
     46.1, 141, 547},
    {"mongon_31m_utm17s_f32", 117, 117, "float32", "EPSG:32717", 30.85, 30.85, 0, 238, 1094},
    {"olympic_N48W125_30m_epsg4326_i16_3601", 3601, 3601, "int16", "EPSG:4326", 0.000277778,
     0.000277778, 50.0, -13, 1095},
    {"portland_10m_epsg4269_f32_nodatablock", 864, 648, "float32", "EPSG:4269", 9.25926e-05,
     9.25926e-05, 33.3, 0, 328.1},
    {"seacliff_aoi4_1m_utm10n_f32_nodata", 427, 721, "float32", "EPSG:26910", 1, 1, 40.6, -0.2,
     105.9},
    {"seacliff_aoi8_1m_utm10n_f32_nodata", 1136, 726, "float32", "EPSG:26910", 1, 1, 18.0, -0.2,
     268.5},
    {"zion_90m_epsg4326_u16", 465, 457, "uint16", "EPSG:4326", 0.000833333, 0.000833333, 0, 1024,
     2892},
};

class RealDem : public testing::TestWithParam<Known> {
 protected:
  void SetUp() override {
    const char* const data = std::getenv("HOODOO_TEST_DATA");
    path_ = std::filesystem::path(data ? data : "../shared/data") / "dem" /
            (std::string(GetParam().file) + ".tif");
    if (!std::filesystem::exists(path_)) GTEST_SKIP() << path_ << " is not there";
  }
  std::filesystem::path path_;
};

TEST_P(RealDem, IsReadAsGdalReadsIt) {
  const auto& k = GetParam();
  auto raster = Raster::open(path_);
  const auto& info = raster->info();
  EXPECT_EQ(info.width, k.width);
  EXPECT_EQ(info.height, k.height);
  EXPECT_EQ(info.sample, k.sample);
  EXPECT_EQ(info.crs, k.crs);
  EXPECT_NEAR(info.transform[1], k.pixel_x, 1e-5 * k.pixel_x);
  EXPECT_NEAR(info.transform[5], -k.pixel_y, 1e-5 * k.pixel_y);
  std::vector<double> pixels;
  raster->read(0, 0, k.width, k.height, pixels);
  double low = 1e9, high = -1e9, holes = 0;
  for (const double v : pixels) {
    if (std::isnan(v)) {
      ++holes;
    } else {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  EXPECT_NEAR(low, k.low, 0.06);
  EXPECT_NEAR(high, k.high, 0.06);
  EXPECT_NEAR(100 * holes / static_cast<double>(pixels.size()), k.nodata_share, 0.051);
}

TEST_P(RealDem, IsIngestedWithItsElevationsAndHoles) {
  const ScratchFolder folder;
  const auto placed = place(*Raster::open(path_), {});
  IngestSettings settings;
  settings.threads = 2;
  const auto p =
      Pyramid::ingest(path_, placed.frame, placed.spacing, {}, folder / "cache", settings);
  const auto& k = GetParam();
  const bool copied = std::string(k.crs) == placed.frame.crs;
  const auto extent = p->extent();
  // Bicubic sampling overshoots a little, by a tenth of the relief beside cliffs and voids.
  const double slack = copied ? 0.06 : 0.1 * (k.high - k.low);
  EXPECT_NEAR(extent.min.z, k.low, slack);
  EXPECT_NEAR(extent.max.z, k.high, slack);
  EXPECT_GE(extent.min.x, 0);
  EXPECT_LT(extent.min.x, placed.spacing);
  EXPECT_LT(extent.min.y, placed.spacing);
  const auto& level = p->levels()[0];
  EXPECT_NEAR(std::min(level.dx, level.dy), placed.spacing, step_of(placed.spacing));

  // Resampled, a raster stands askew in its box, whose corners are holes too.
  const auto w = p->window(0, extent);
  double holes = 0, count = 0;
  const int step = copied ? 1 : 3;
  for (std::int64_t j = 0; j < level.height; j += step) {
    for (std::int64_t i = 0; i < level.width; i += step) {
      holes += !w.valid(level.x0 + (static_cast<double>(i) + 0.5) * level.dx,
                        level.y0 + (static_cast<double>(j) + 0.5) * level.dy);
      ++count;
    }
  }
  EXPECT_NEAR(100 * holes / count, k.nodata_share, copied ? 0.051 : 8);
}

INSTANTIATE_TEST_SUITE_P(Of13, RealDem, testing::ValuesIn(known),
                         [](const auto& of) { return std::string(of.param.file); });

}  // namespace
}  // namespace hoodoo::dem
