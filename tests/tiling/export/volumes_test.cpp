// Level sets and height maps, read back by OpenVDB, OpenImageIO and engine/dem.
#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "engine/dem/raster.hpp"
#include "tests/tiling/tileset/world.hpp"
#include "tiling/export/export.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using shapes::Folder;
using shapes::World;
using testing::HasSubstr;

/// A plane that rises to the east and north, over 64 x 64 m of tiles of 16 m.
double plane(double x, double y) { return 5 + x / 4 + y / 8; }

struct Grids : testing::Test {
  Folder folder{"export-plane"}, out{"export-grids"};
  tileset::Bake bake;
  Report report;

  void SetUp() override { bake_plane(false); }
  void bake_plane(bool strip) {
    World world;
    world.levels = 3;
    world.strip = strip;
    world.change = [](const plan::Key&, glb::Content& content) {
      for (auto& p : content.surface.points) {
        const auto at = [&](std::size_t a) {
          return static_cast<double>(content.origin[a] + p[a]) * content.step;
        };
        p[2] = static_cast<std::int32_t>(std::nearbyint(plane(at(0), at(1)) / content.step));
      }
    };
    bake = world.make(folder.path);
    bake.frame = {.crs = "EPSG:32632", .unit = 1, .origin_x = 400'000, .origin_y = 5'000'000};
    tileset::write_index(bake, tileset::estimate_errors(bake), folder.path);
  }
  fs::path write(const std::string& name, const Settings& settings = {}) {
    const auto file = out.path / name;
    report = run(folder.path, file, format_of(file, ""), settings);
    return file;
  }
};

struct LevelSet : Grids {
  openvdb::FloatGrid::Ptr read(const fs::path& path) {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open();
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"));
    file.close();
    return grid;
  }
  static double at(const openvdb::FloatGrid& grid, double x, double y, double z) {
    const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> sampler(grid);
    return static_cast<double>(sampler.wsSample({x, y, z}));
  }
};

TEST_F(LevelSet, IsTheDistanceToTheSurfaceNegativeInside) {
  const auto grid = read(write("a.vdb"));
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(grid->voxelSize(), openvdb::Vec3d(1));
  EXPECT_EQ(report.voxels, grid->activeVoxelCount());
  const double upright = std::sqrt(1 + 1.0 / 16 + 1.0 / 64);  // of height over the plane
  for (const double x : {8.0, 31.0, 32.0, 55.5}) {
    for (const double y : {9.0, 16.0, 40.25}) {
      for (const double above : {-2.0, -0.5, 0.0, 1.0, 2.5}) {
        EXPECT_NEAR(at(*grid, x, y, plane(x, y) + above), above / upright, 0.05) << x << " " << y;
      }
    }
  }
}

TEST_F(LevelSet, IsClosedByWallsAndAFloor) {
  const auto grid = read(write("a.vdb"));
  const double deep = -static_cast<double>(grid->background());
  EXPECT_EQ(at(*grid, 32, 32, 6), deep);
  EXPECT_EQ(at(*grid, 60, 4, 10), deep) << "near the wall, but not within the band";
  EXPECT_NEAR(at(*grid, 63, 32, 10), -1, 0.02) << "the eastern wall";
  EXPECT_NEAR(at(*grid, 65.5, 32, 10), 1.5, 0.02);
  EXPECT_NEAR(at(*grid, 32, -1, 3), 1, 0.02) << "the southern wall";
  EXPECT_NEAR(at(*grid, 32, 32, 5 - 4 + 1), -1, 0.02) << "four voxels below the lowest point";
  EXPECT_NEAR(at(*grid, 32, 32, 5 - 4 - 2), 2, 0.02);
  EXPECT_EQ(at(*grid, 32, 32, 60), -deep);
  EXPECT_EQ(at(*grid, 32, 32, -60), -deep);
  EXPECT_EQ(at(*grid, -60, 32, 10), -deep);
}

TEST_F(LevelSet, HasTheVoxelsOfTheLevelOrThoseAskedFor) {
  EXPECT_EQ(read(write("a.vdb", {.level = 1}))->voxelSize(), openvdb::Vec3d(2));
  const auto fine = read(write("a.vdb", {.voxel = 0.5}));
  EXPECT_EQ(fine->voxelSize(), openvdb::Vec3d(0.5));
  EXPECT_NEAR(at(*fine, 20, 20, plane(20, 20)), 0, 0.01);
  try {
    write("a.vdb", {.voxel = 1e-4});
    FAIL() << "was not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
    EXPECT_THAT(error.what(), HasSubstr("--voxel: 0.0001 m would make"));
  }
}

struct HeightMap : Grids {
  std::vector<std::uint16_t> pixels;
  int width = 0, height = 0;
  json place;

  void read(const fs::path& file) {
    const auto image = OIIO::ImageInput::open(file.string());
    ASSERT_TRUE(image);
    width = image->spec().width;
    height = image->spec().height;
    EXPECT_EQ(image->spec().nchannels, 1);
    EXPECT_EQ(image->spec().format, OIIO::TypeDesc::UINT16);
    pixels.resize(static_cast<std::size_t>(width * height));
    ASSERT_TRUE(image->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT16, pixels.data()));
    place = json::parse(read_file(file.string() + ".json", 1 << 20));
    EXPECT_EQ(place["width"], width);
    EXPECT_EQ(place["height"], height);
    EXPECT_EQ(report.width, width);
    EXPECT_EQ(report.height, height);
  }
  std::uint16_t value(int i, int j) const {
    return pixels[static_cast<std::size_t>(j * width + i)];
  }
  /// Every pixel has the height of the plane at its centre, as the sidecar says.
  void expect_plane() const {
    const double pixel = place["pixel"], offset = place["offset"], scale = place["scale"];
    for (int j = 0; j < height; ++j) {
      for (int i = 0; i < width; ++i) {
        const double x = place["region"][0].get<double>() + (i + 0.5) * pixel;
        const double y = place["region"][3].get<double>() - (j + 0.5) * pixel;
        ASSERT_GT(value(i, j), 0) << i << " " << j;
        ASSERT_NEAR(offset + scale * value(i, j), plane(x, y), 0.51 * scale + 1.0 / 256);
      }
    }
  }
};

TEST_F(HeightMap, ShowsTheSurfaceOverEachPixelsCentre) {
  for (const char* name : {"a.png", "a.tif"}) {
    read(write(name));
    EXPECT_EQ(width, 64);
    EXPECT_EQ(height, 64);
    expect_plane();
  }
}

TEST_F(HeightMap, HasThePixelsAskedFor) {
  read(write("a.png", {.pixel = 0.3}));
  EXPECT_EQ(width, 214);
  EXPECT_EQ(value(213, 100), 0) << "its centre at 64.05 m lies outside";
  read(write("a.png", {.level = 1, .pixel = 4}));
  EXPECT_EQ(width, 16);
  expect_plane();
}

TEST_F(HeightMap, IsCutToARegion) {
  read(write("a.png", {.region = Region{10.5, 20, 40, 31}}));
  EXPECT_EQ(place["region"], json({10.0, 20.0, 40.0, 31.0}));
  EXPECT_EQ(width, 30);
  EXPECT_EQ(height, 11);
  expect_plane();
}

TEST_F(HeightMap, HasNoValueWhereThereIsNoSurface) {
  bake_plane(true);  // the southern 16 m alone
  read(write("a.png", {.region = Region{0, 0, 64, 40}}));
  EXPECT_EQ(height, 40);
  for (int i = 0; i < width; ++i) {
    for (int j = 0; j < 24; ++j) ASSERT_EQ(value(i, j), 0);
    for (int j = 24; j < 40; ++j) ASSERT_GT(value(i, j), 0);
  }
}

TEST_F(HeightMap, StandsAtItsPlaceInTheCrs) {
  const auto info = dem::Raster::open(write("a.tif", {.region = Region{16, 0, 64, 32}}))->info();
  EXPECT_EQ(info.crs, "EPSG:32632");
  EXPECT_EQ(info.width, 48);
  EXPECT_EQ(info.height, 32);
  EXPECT_EQ(info.transform, (std::array<double, 6>{400'016, 1, 0, 5'000'032, 0, -1}));
  ASSERT_TRUE(info.nodata.has_value());
  EXPECT_EQ(*info.nodata, 0);
}

TEST_F(HeightMap, RefusesMorePixelsThanCanBe) {
  try {
    write("a.png", {.pixel = 1e-5});
    FAIL() << "was not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
    EXPECT_THAT(error.what(), HasSubstr("--pixel: 1e-05 m would make 6400000 x 6400000 pixels"));
  }
}

}  // namespace
}  // namespace hoodoo::exporting
