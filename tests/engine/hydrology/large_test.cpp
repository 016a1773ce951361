#include "engine/hydrology/large.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "engine/base/error.hpp"
#include "engine/hydrology/accessibility.hpp"
#include "engine/hydrology/raster_writer.hpp"
#include "engine/hydrology/sea_distance.hpp"
#include "tests/engine/hydrology/grids.hpp"

namespace hoodoo::hydrology {
namespace {

namespace fs = std::filesystem;

fs::path dem(const char* name) {
  const char* data = std::getenv("HOODOO_TEST_DATA");
  return data == nullptr ? fs::path() : fs::path(data) / "dem" / name;
}
constexpr auto in_metres = "mongon_31m_utm17s_f32.tif";
constexpr auto in_degrees = "olympic_N48W125_30m_epsg4326_i16_3601.tif";

/// The same bits, all NaN alike.
void expect_same(const std::vector<float>& found, const std::vector<float>& expected,
                 const char* what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t c = 0; c < found.size(); ++c) {
    if (std::isnan(found[c]) && std::isnan(expected[c])) continue;
    ASSERT_EQ(std::bit_cast<std::uint32_t>(found[c]), std::bit_cast<std::uint32_t>(expected[c]))
        << what << ", cell " << c << ": " << found[c] << " for " << expected[c];
  }
}

class Large : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(dem(in_metres))) GTEST_SKIP() << "no test data";
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write_dem(const Grid& grid, const char* place) {
    const auto file = folder_ / "dem.tif";
    RasterWriter writer(file, dem(place), grid.width, grid.height);
    writer.append(grid.z);
    writer.commit();
    return file;
  }

  /// Everything of the file in parts of at most so many rows against the grid in one.
  void compare(const fs::path& file, std::int32_t rows, Routing routing) {
    SCOPED_TRACE(rows);
    const Grid grid = read(file);
    LargeDem large(file, {std::size_t{1} << 30, folder_, rows});
    const auto all = [](const auto& make) {
      std::vector<float> values;
      make([&](std::span<const float> part) {
        values.insert(values.end(), part.begin(), part.end());
      });
      return values;
    };
    Grid filled = grid;
    fill(filled);
    expect_same(all([&](const TakeRows& take) { large.filled(take); }), filled.z, "filled");
    const auto slopes = slope(grid);
    expect_same(all([&](const TakeRows& take) { large.slope(take); }), slopes, "slope");
    const auto drainage = accumulate(filled, receivers(filled, routing));
    EXPECT_EQ(large.accumulate({routing, 1.1}), drainage.outflow);
    expect_same(all([&](const TakeRows& take) { large.area(take); }), drainage.area, "area");
    expect_same(all([&](const TakeRows& take) { large.stream_power(take); }),
                stream_power(drainage, slopes), "power");
    EXPECT_EQ(large.sinks(), sinks(grid, filled));
    const auto some =
        static_cast<double>(*std::ranges::find_if(grid.z, [](float z) { return z == z; }));
    expect_same(all([&](const TakeRows& take) { large.sea_distance(some, take); }),
                sea_distance(grid, some), "sea");
  }

  const fs::path folder_ = fs::temp_directory_path() / ("hoodoo-large-" + std::to_string(getpid()));
};

TEST_F(Large, IsTheSameInPartsOfAnySize) {
  for (std::uint32_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(seed);
    // Few levels make flats and ties across the parts; every third has holes.
    const int levels = seed % 4 == 0 ? 100'000 : seed % 4 == 1 ? 3 : 12;
    const Grid grid =
        rough(seed, 9 + static_cast<std::int32_t>(seed), 47, levels, seed % 3 == 0 ? 0.04 : 0);
    const auto file = write_dem(grid, seed % 2 == 0 ? in_metres : in_degrees);
    for (const std::int32_t rows : {1, 2, 3, 7, 20, 46, 47}) {
      compare(file, rows, seed % 5 == 0 ? Routing::d8 : Routing::freeman);
    }
  }
}

TEST_F(Large, FollowsWaterThatCrossesBordersOverAndOver) {
  // A gorge that winds through all rows in each second column, on flat ground and on falling one.
  for (const float fall : {0.0F, 0.001F}) {
    Grid grid = grid_of(21, std::vector<float>(21 * 40, 9));
    float z = 3;
    for (std::int32_t i = 1; i < 20; ++i) {
      const bool up = i % 4 == 3;
      const std::int32_t from = i % 2 == 1 ? 1 : i % 4 == 2 ? 38 : 1;
      const std::int32_t to = i % 2 == 1 ? 38 : from;
      for (std::int32_t n = from; n <= to; ++n) {
        grid.z[grid.index(i, i % 2 == 1 && up ? 39 - n : n)] = z -= fall;
      }
    }
    grid.z[grid.index(20, 38)] = 0;
    const auto file = write_dem(grid, in_metres);
    for (const std::int32_t rows : {1, 4, 15}) compare(file, rows, Routing::freeman);
  }
}

TEST_F(Large, IsTheSameOfARealDem) {
  compare(dem(in_metres), 100, Routing::freeman);
  compare(dem("seacliff_aoi8_1m_utm10n_f32_nodata.tif"), 64, Routing::d8);
}

TEST_F(Large, LooksAsFarAsBallsReach) {
  const auto file = write_dem(rough(5, 30, 80, 400, 0.02), in_metres);
  const Grid grid = read(file);
  const double most = 6 * grid.dx[0];
  std::vector<float> values;
  LargeDem(file, {std::size_t{1} << 30, folder_, 40}).accessibility(most, [&](auto rows) {
    values.insert(values.end(), rows.begin(), rows.end());
  });
  expect_same(values, accessibility(grid, most, {0, grid.height}), "accessibility");
}

TEST_F(Large, TellsWhatMemoryWouldDo) {
  const auto file = write_dem(rough(1, 400, 300, 50, 0), in_metres);
  try {
    LargeDem(file, {200'000, folder_});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
    EXPECT_NE(std::string(error.what()).find("need"), std::string::npos) << error.what();
  }
}

TEST_F(Large, TellsHowManyPitsMemoryHolds) {
  const auto file = write_dem(rough(2, 50, 4000, 100'000, 0), in_metres);
  EXPECT_GT(LargeDem(file, {std::size_t{4} << 20, folder_}).sinks().size(), 10'000U);
  try {
    LargeDem(file, {std::size_t{1} << 20, folder_}).sinks();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::limit);
    EXPECT_NE(std::string(error.what()).find("pits"), std::string::npos) << error.what();
  }
}

TEST_F(Large, KeepsNoFileInItsFolder) {
  const auto file = write_dem(rough(1, 40, 30, 50, 0), in_metres);
  LargeDem large(file, {std::size_t{1} << 30, folder_, 7});
  large.accumulate({});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace hoodoo::hydrology
