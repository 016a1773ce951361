#include "engine/dem/raster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/engine/dem/written_tiff.hpp"

namespace hoodoo::dem {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> all_of(Raster& raster) {
  std::vector<double> out;
  raster.read(0, 0, static_cast<int>(raster.info().width), static_cast<int>(raster.info().height),
              out);
  return out;
}

Error error_of(const std::filesystem::path& path, const RasterLimits& limits = {}) {
  try {
    auto raster = Raster::open(path, limits);
    all_of(*raster);
  } catch (const Error& error) {
    EXPECT_EQ(error.problems.front().where, path.string());
    return error;
  }
  return Error(Fault::internal, "", "no error at all");
}

// Values that use every byte of the type, differently in each pixel.
template <class T>
std::vector<T> varied(int count) {
  std::vector<T> samples;
  std::uint64_t state = 12345;
  for (int k = 0; k < count; ++k) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    if constexpr (std::is_floating_point_v<T>) {
      samples.push_back(static_cast<T>(static_cast<double>(state >> 11) * 1e-9 - 4e6));
    } else {
      samples.push_back(static_cast<T>(state >> 13));
    }
  }
  return samples;
}

template <class T>
void expect_round_trip(const std::string& what, const TiffOptions& options) {
  const ScratchFolder folder;
  const int width = 83, height = 57;
  const auto samples = varied<T>(width * height);
  auto raster = Raster::open(write_tiff(folder / "dem.tif", width, height, samples, options));
  const auto read = all_of(*raster);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    ASSERT_EQ(read[k], static_cast<double>(samples[k])) << what << ", sample " << k;
  }
}

template <class T>
void expect_round_trips(const std::string& type) {
  for (const int compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE,
                                COMPRESSION_ZSTD, COMPRESSION_PACKBITS}) {
    const bool predicts = compression != COMPRESSION_NONE && compression != COMPRESSION_PACKBITS;
    for (int predictor = 1; predictor <= (predicts ? 3 : 1); ++predictor) {
      if (predictor == 3 && !std::is_floating_point_v<T>) continue;
      for (const int tile : {0, 16, 64}) {
        for (const char* mode : {"w", "w8", "wb"}) {
          if (mode == std::string("wb") && predictor == 3) continue;
          TiffOptions o;
          o.mode = mode;
          o.tile = tile;
          o.rows_per_strip = tile ? 4 : 5;
          o.compression = compression;
          o.predictor = predictor;
          expect_round_trip<T>(type + " compression " + std::to_string(compression) +
                                   " predictor " + std::to_string(predictor) + " tile " +
                                   std::to_string(tile) + " mode " + mode,
                               o);
        }
      }
    }
  }
}

TEST(Raster, ReadsEveryLayoutOfInt16) { expect_round_trips<std::int16_t>("int16"); }
TEST(Raster, ReadsEveryLayoutOfUint16) { expect_round_trips<std::uint16_t>("uint16"); }
TEST(Raster, ReadsEveryLayoutOfFloat32) { expect_round_trips<float>("float32"); }
TEST(Raster, ReadsEveryLayoutOfFloat64) { expect_round_trips<double>("float64"); }
TEST(Raster, ReadsEveryLayoutOfBytes) {
  expect_round_trips<std::uint8_t>("uint8");
  expect_round_trips<std::int8_t>("int8");
}
TEST(Raster, ReadsEveryLayoutOfInt32) {
  expect_round_trips<std::int32_t>("int32");
  expect_round_trips<std::uint32_t>("uint32");
}

TEST(Raster, ReadsStripsOfOneRowAndOfTheWholeRaster) {
  for (const int rows : {1, 57, 1000}) {
    TiffOptions o;
    o.rows_per_strip = rows;
    o.compression = COMPRESSION_ADOBE_DEFLATE;
    expect_round_trip<double>("float64 rows " + std::to_string(rows), o);
    expect_round_trip<std::int16_t>("int16 rows " + std::to_string(rows), o);
  }
}

TEST(Raster, GivesTheSamePixelsWindowByWindowWithASmallCache) {
  const ScratchFolder folder;
  TiffOptions o;
  o.tile = 16;
  const auto samples = varied<float>(100 * 70);
  auto raster = Raster::open(write_tiff(folder / "dem.tif", 100, 70, samples, o));
  raster->keep(0);
  std::vector<double> out;
  for (int j = 66; j >= 0; j -= 3) {
    for (int i = 0; i < 93; i += 5) {
      raster->read(i, j, 7, 4, out);
      for (int l = 0; l < 4; ++l) {
        for (int k = 0; k < 7; ++k) {
          ASSERT_EQ(out[static_cast<std::size_t>(7 * l + k)],
                    static_cast<double>(samples[static_cast<std::size_t>((j + l) * 100 + i + k)]));
        }
      }
    }
  }
}

TEST(Raster, TakesABlockLeftOutByASparseFileAsNoData) {
  const ScratchFolder folder;
  TiffOptions o;
  o.tile = 16;
  o.missing = {1};
  auto raster =
      Raster::open(write_tiff(folder / "dem.tif", 32, 16, std::vector<float>(32 * 16, 5.0f), o));
  const auto read = all_of(*raster);
  for (std::size_t k = 0; k < read.size(); ++k) {
    if (k % 32 < 16) {
      EXPECT_EQ(read[k], 5);
    } else {
      EXPECT_TRUE(std::isnan(read[k]));
    }
  }
}

template <class T>
std::vector<double> with_nodata(const std::string& tag, const std::vector<T>& samples) {
  const ScratchFolder folder;
  TiffOptions o;
  o.nodata = tag;
  o.rows_per_strip = 1;
  auto raster =
      Raster::open(write_tiff(folder / "dem.tif", static_cast<int>(samples.size()), 1, samples, o));
  return all_of(*raster);
}

MATCHER(SameNumber, "") {
  const auto [a, b] = arg;
  return a == b || (std::isnan(a) && std::isnan(b));
}

TEST(Raster, ComparesTheNoDataTagInThePrecisionOfTheSamples) {
  using testing::Pointwise;
  EXPECT_THAT((with_nodata<std::int16_t>("-32768", {-32768, 0, 7})),
              Pointwise(SameNumber(), std::vector{nan, 0.0, 7.0}));
  EXPECT_THAT((with_nodata<std::uint16_t>("-32768", {0, 65535, 32768})),
              Pointwise(SameNumber(), std::vector{0.0, 65535.0, 32768.0}));
  EXPECT_THAT((with_nodata<float>("-9999.9", {-9999.9f, -9999.0f})),
              Pointwise(SameNumber(), std::vector{nan, -9999.0}));
  EXPECT_THAT((with_nodata<double>("-9999.9", {-9999.9, -9999.0})),
              Pointwise(SameNumber(), std::vector{nan, -9999.0}));
  EXPECT_THAT((with_nodata<float>("0", {0.0f, -0.0f, 1.0f})),
              Pointwise(SameNumber(), std::vector{nan, nan, 1.0}));
  EXPECT_THAT((with_nodata<std::uint64_t>("18446744073709551615",
                                          {std::numeric_limits<std::uint64_t>::max(), 3})),
              Pointwise(SameNumber(), std::vector{nan, 3.0}));
}

TEST(Raster, TakesTheCustomaryMarksForNoDataHoweverTheyArePrinted) {
  using testing::Pointwise;
  constexpr float low = std::numeric_limits<float>::lowest();
  for (const char* tag : {"", "-3.4e+38", "-3.40282e+38", "nan", "-inf", "1.#QNAN", "garbage"}) {
    EXPECT_THAT((with_nodata<float>(tag, {low, 1.70141e38f, std::nanf(""), -1 / 0.0f, 12.5f})),
                Pointwise(SameNumber(), std::vector{nan, nan, nan, nan, 12.5}))
        << tag;
  }
}

TEST(Raster, KnowsItsCrsByCodeAndItsTransform) {
  const ScratchFolder folder;
  TiffOptions o;
  o.scale = {30, 20, 0};
  o.ties = {0, 0, 0, 500000, 5000000, 0};
  o.keys = utm(32632);
  const std::vector<float> samples(12, 1.0f);
  auto area = Raster::open(write_tiff(folder / "area.tif", 4, 3, samples, o));
  EXPECT_EQ(area->info().crs, "EPSG:32632");
  EXPECT_EQ(area->info().crs_name, "WGS 84 / UTM zone 32N");
  EXPECT_EQ(area->info().kind, RasterInfo::Crs::projected);
  EXPECT_THAT(area->info().transform, testing::ElementsAre(500000, 30, 0, 5000000, 0, -20));

  o.keys = utm(32632, RasterPixelIsPoint);
  auto point = Raster::open(write_tiff(folder / "point.tif", 4, 3, samples, o));
  EXPECT_TRUE(point->info().pixel_is_point);
  EXPECT_THAT(point->info().transform, testing::ElementsAre(499985, 30, 0, 5000010, 0, -20));

  o.keys = degrees(4269);
  o.scale = {0.5, 0.25, 0};
  o.ties = {1, 1, 0, 7, 47, 0};
  auto geographic = Raster::open(write_tiff(folder / "degrees.tif", 4, 3, samples, o));
  EXPECT_EQ(geographic->info().kind, RasterInfo::Crs::geographic);
  EXPECT_EQ(geographic->info().crs, "EPSG:4269");
  EXPECT_THAT(geographic->info().transform, testing::ElementsAre(6.5, 0.5, 0, 47.25, 0, -0.25));
}

TEST(Raster, ReadsARotatedMatrix) {
  const ScratchFolder folder;
  TiffOptions o;
  o.matrix = {8, 6, 0, 100, 6, -8, 0, 200, 0, 0, 0, 0, 0, 0, 0, 1};
  auto raster = Raster::open(write_tiff(folder / "dem.tif", 4, 3, std::vector<float>(12, 1.0f), o));
  EXPECT_THAT(raster->info().transform, testing::ElementsAre(100, 8, 6, 200, 6, -8));
  EXPECT_EQ(raster->info().kind, RasterInfo::Crs::none);
}

TEST(Raster, WithoutGeoreferenceHasPixelsOfOneMetre) {
  const ScratchFolder folder;
  auto raster = Raster::open(write_tiff(folder / "dem.tif", 4, 3, std::vector<float>(12, 1.0f)));
  EXPECT_THAT(raster->info().transform, testing::ElementsAre(0, 1, 0, 0, 0, -1));
  EXPECT_EQ(raster->info().kind, RasterInfo::Crs::none);
  EXPECT_EQ(raster->info().crs, "");
}

TEST(Raster, KnowsACrsInFeet) {
  const ScratchFolder folder;
  TiffOptions o;
  o.scale = {10, 10, 0};
  o.ties = {0, 0, 0, 2000000, 500000, 0};
  o.keys = utm(2222);  // NAD83 / Arizona East, international feet
  const std::vector<float> samples(12, 1.0f);
  auto raster = Raster::open(write_tiff(folder / "dem.tif", 4, 3, samples, o));
  EXPECT_DOUBLE_EQ(raster->info().unit, 0.3048);
  EXPECT_DOUBLE_EQ(raster->info().transform[1], 10);

  // A file may state its coordinates in feet though its CRS is in metres.
  o.keys = [](GTIF* g) {
    utm(32612)(g);
    GTIFKeySet(g, ProjLinearUnitsGeoKey, TYPE_SHORT, 1, 9002);
    GTIFKeySet(g, VerticalUnitsGeoKey, TYPE_SHORT, 1, 9003);
  };
  auto mixed = Raster::open(write_tiff(folder / "mixed.tif", 4, 3, samples, o));
  EXPECT_EQ(mixed->info().unit, 1);
  EXPECT_NEAR(mixed->info().transform[1], 3.048, 1e-12);
  EXPECT_NEAR(mixed->info().vertical_unit, 1200.0 / 3937, 1e-12);
}

std::function<void(GTIF*)> mercator_by_parameters(double minor_axis) {
  return [=](GTIF* g) {
    GTIFKeySet(g, GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
    GTIFKeySet(g, ProjectedCSTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
    GTIFKeySet(g, ProjectionGeoKey, TYPE_SHORT, 1, KvUserDefined);
    GTIFKeySet(g, ProjCoordTransGeoKey, TYPE_SHORT, 1, CT_Mercator);
    GTIFKeySet(g, ProjLinearUnitsGeoKey, TYPE_SHORT, 1, 9001);
    GTIFKeySet(g, GeographicTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
    GTIFKeySet(g, GeogGeodeticDatumGeoKey, TYPE_SHORT, 1, KvUserDefined);
    GTIFKeySet(g, GeogEllipsoidGeoKey, TYPE_SHORT, 1, KvUserDefined);
    GTIFKeySet(g, GeogSemiMajorAxisGeoKey, TYPE_DOUBLE, 1, 6378137.0);
    GTIFKeySet(g, GeogSemiMinorAxisGeoKey, TYPE_DOUBLE, 1, minor_axis);
    GTIFKeySet(g, ProjNatOriginLongGeoKey, TYPE_DOUBLE, 1, 0.0);
    GTIFKeySet(g, ProjNatOriginLatGeoKey, TYPE_DOUBLE, 1, 0.0);
    GTIFKeySet(g, ProjScaleAtNatOriginGeoKey, TYPE_DOUBLE, 1, 1.0);
    GTIFKeySet(g, ProjFalseEastingGeoKey, TYPE_DOUBLE, 1, 0.0);
    GTIFKeySet(g, ProjFalseNorthingGeoKey, TYPE_DOUBLE, 1, 0.0);
  };
}

TEST(Raster, KnowsWebMercatorByCodeAndByParameters) {
  const ScratchFolder folder;
  TiffOptions o;
  o.scale = {30, 30, 0};
  o.ties = {0, 0, 0, 890000, 5900000, 0};
  const std::vector<float> samples(12, 1.0f);
  o.keys = utm(3857);
  EXPECT_EQ(Raster::open(write_tiff(folder / "a.tif", 4, 3, samples, o))->info().kind,
            RasterInfo::Crs::web_mercator);
  o.keys = mercator_by_parameters(6378137.0);
  auto given = Raster::open(write_tiff(folder / "b.tif", 4, 3, samples, o));
  EXPECT_EQ(given->info().kind, RasterInfo::Crs::web_mercator);
  EXPECT_THAT(given->info().crs, testing::StartsWith("PROJCRS"));
  o.keys = mercator_by_parameters(6356752.314245179);
  EXPECT_EQ(Raster::open(write_tiff(folder / "c.tif", 4, 3, samples, o))->info().kind,
            RasterInfo::Crs::projected);
}

TEST(Raster, RefusesWhatIsNotOneBandOfElevations) {
  const ScratchFolder folder;
  TiffOptions rgb;
  rgb.bands = 3;
  rgb.photometric = PHOTOMETRIC_RGB;
  const auto colours = write_tiff(folder / "rgb.tif", 4, 3, std::vector<std::uint8_t>(36, 1), rgb);
  EXPECT_EQ(error_of(colours).fault, Fault::bad_input);
  EXPECT_THAT(error_of(colours).what(), testing::HasSubstr("3 bands"));
  EXPECT_EQ(error_of(folder / "missing.tif").fault, Fault::not_found);
  EXPECT_EQ(error_of(folder / "").fault, Fault::bad_input);
  write_file(folder / "text.tif", "no TIFF at all");
  EXPECT_EQ(error_of(folder / "text.tif").fault, Fault::bad_input);
}

TEST(Raster, RefusesBigEndianPredictor3WhichLibtiffDecodesWrongly) {
  const ScratchFolder folder;
  TiffOptions o;
  o.mode = "wb";
  o.compression = COMPRESSION_LZW;
  o.predictor = 3;
  const auto path = write_tiff(folder / "dem.tif", 4, 3, std::vector<float>(12, 1.0f), o);
  EXPECT_EQ(error_of(path).fault, Fault::bad_input);
  EXPECT_THAT(error_of(path).what(), testing::HasSubstr("predictor 3"));
}

TEST(Raster, RefusesWhatIsOverALimitBeforeReadingIt) {
  const ScratchFolder folder;
  const auto path = write_tiff(folder / "dem.tif", 64, 64, std::vector<float>(64 * 64, 1.0f), {});
  EXPECT_EQ(error_of(path, {.pixels = 4095}).fault, Fault::limit);
  EXPECT_EQ(error_of(path, {.block_bytes = 1023}).fault, Fault::limit);
  EXPECT_EQ(error_of(path, {.pixels = 4096, .block_bytes = 1024}).fault, Fault::internal);
}

// Moves the last block of a little-endian classic TIFF to the end of the file, where nothing is.
void lose_last_block(const std::filesystem::path& path, std::uint16_t offsets_tag) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const auto number = [&](std::uint64_t at, auto value) {
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  };
  const std::uint64_t directory = number(4, std::uint32_t{});
  for (std::uint64_t entry = directory + 2;; entry += 12) {
    if (number(entry, std::uint16_t{}) != offsets_tag) continue;
    const auto count = number(entry + 4, std::uint32_t{});
    const std::uint64_t table = number(entry + 8, std::uint32_t{});
    const auto end = static_cast<std::uint32_t>(std::filesystem::file_size(path));
    file.seekp(static_cast<std::streamoff>(table + 4 * (count - 1)));
    file.write(reinterpret_cast<const char*>(&end), sizeof end);
    return;
  }
}

TEST(Raster, SaysWhichRowsOfATruncatedFileAreGone) {
  const ScratchFolder folder;
  for (const int tile : {0, 16}) {
    TiffOptions o;
    o.tile = tile;
    const auto path = write_tiff(folder / "dem.tif", 64, 64, std::vector<float>(64 * 64, 1.0f), o);
    lose_last_block(path, tile ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS);
    const auto error = error_of(path);
    EXPECT_EQ(error.fault, Fault::bad_input);
    EXPECT_THAT(error.what(), testing::HasSubstr("is cut short"));
    EXPECT_THAT(error.what(), testing::HasSubstr(tile ? "rows 48 to 63" : "rows 60 to 63"));
  }
}

TEST(Raster, TellsAboutItselfAsJson) {
  const ScratchFolder folder;
  TiffOptions o;
  o.nodata = "nan";
  const auto path = write_tiff(folder / "dem.tif", 4, 3, std::vector<float>(12, 1.0f), o);
  const auto json = to_json(Raster::open(path)->info());
  EXPECT_EQ(json.at("width"), 4);
  EXPECT_EQ(json.at("nodata"), "nan");
  EXPECT_EQ(json.at("layout"), "striped 3 rows");
  EXPECT_EQ(json.at("kind"), "none");
}

}  // namespace
}  // namespace hoodoo::dem
