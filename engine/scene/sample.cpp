#include "engine/scene/sample.hpp"

#include <fmt/format.h>
#include <geotiffio.h>
#include <xtiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <system_error>

#include "engine/base/error.hpp"
#include "engine/base/noise.hpp"

namespace hoodoo::scene {
namespace {

constexpr int tile = 256;                            // pixels
constexpr double east = 400'000, north = 4'100'000;  // UTM 12N of the south-west corner [m]

/// 0 below 0, 1 above 1, flat at both.
double step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
double mix(double a, double b, double t) { return a + (b - a) * t; }

double distance_to_segment(double x, double y, std::array<double, 2> a, std::array<double, 2> b) {
  const double ux = b[0] - a[0], uy = b[1] - a[1];
  const double t = std::clamp(((x - a[0]) * ux + (y - a[1]) * uy) / (ux * ux + uy * uy), 0.0, 1.0);
  const double dx = x - a[0] - t * ux, dy = y - a[1] - t * uy;
  return std::sqrt(dx * dx + dy * dy);
}

/// Noise about 0, within [-1, 1], along one row.
std::vector<double> wave(const SampleDem& sample, double y, bool along_x, bool along_y,
                         const Turbulence& noise) {
  const auto n = static_cast<std::size_t>(sample.pixels);
  std::vector<float> px(n), py(n, 0.0F), pz(n, 0.0F), out(n);
  for (std::size_t i = 0; i < n && along_x; ++i) {
    px[i] = static_cast<float>((static_cast<double>(i) + 0.5) * sample.spacing);
  }
  turbulence(noise, {0, along_y ? y : 0, 0}, px, py, pz, out);
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i) values[i] = 2 * static_cast<double>(out[i]) - 1;
  return values;
}

/// The noises that the coast is made of, along one row.
struct Waves {
  std::vector<double> coast, bend, swell, ribs, rough, hills;

  Waves(const SampleDem& sample, double y)
      : coast(wave(sample, y, false, true, {260, 3, sample.seed})),
        bend(wave(sample, y, true, false, {460, 2, sample.seed + 1})),
        swell(wave(sample, y, true, true, {330, 3, sample.seed + 2})),
        ribs(wave(sample, y, true, true, {84, 2, sample.seed + 3})),
        rough(wave(sample, y, true, true, {30, 3, sample.seed + 4})),
        hills(wave(sample, y, true, true, {2400, 5, sample.seed + 5})) {}
};

/// A steep-sided rock in the sea: `top` inside `radius`, falling to `foot` across `flank`.
double rock(double distance, double radius, double flank, double top, double foot) {
  return mix(top, foot, step((distance - radius) / flank));
}

double elevation(double x, double y, const Waves& w, std::size_t i) {
  const double ribs = w.ribs[i], rough = w.rough[i];
  const double sea = mix(-16, -6, step(x / 320)) + 1.5 * ribs;

  // Inland: a plateau that rises to hills, cut by gullies along the zero lines of the swell.
  const double hills = 260 * step((x - 1200) / 2500) * std::max(0.0, w.hills[i] + 0.35);
  const double gully = 1 - step(std::abs(w.swell[i] + 0.1 * ribs) / 0.4);
  const double plateau = 114 + 22 * w.swell[i] + 1.5 * rough - 14 * gully + hills;

  // The valley: a flat floor, walls with ribs, a stream bed.
  const double off = std::abs(y - (735 + 150 * w.bend[i]));
  const double stream = 3 * (1 - step(off / 9));
  const double floor = 5 + 42 * step((x - 330) / 900) + rough - stream;
  const double land = mix(floor, plateau, step((off + 26 * ribs + 5 * rough - 30) / 92));

  const double shore = 352 + 120 * w.coast[i] + 16 * ribs + 3 * rough;
  const double h = mix(sea, land, step((x - shore + 13) / 26));

  const double spur = distance_to_segment(x, y, {196, 300}, {430, 326}) - 15 * ribs - 2 * rough;
  const double stack = distance_to_segment(x, y, {56, 278}, {64, 290}) - 7 * ribs - 2 * rough;
  return std::max({h, rock(spur, 30, 22, 76 + 10 * w.swell[i] + 2 * rough, sea),
                   rock(stack, 20, 20, 60 + 3 * rough, sea)});
}

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw Error(Fault::io, path.string(), "cannot be written");
}

void write_tags(TIFF* file, const SampleDem& sample) {
  const auto side = static_cast<std::uint32_t>(sample.pixels);
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, side);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, side);
  TIFFSetField(file, TIFFTAG_TILEWIDTH, tile);
  TIFFSetField(file, TIFFTAG_TILELENGTH, tile);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(file, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
  const std::array<double, 3> scale{sample.spacing, sample.spacing, 0};
  const std::array<double, 6> corner{0, 0, 0, east, north + sample.pixels * sample.spacing, 0};
  TIFFSetField(file, TIFFTAG_GEOPIXELSCALE, 3, scale.data());
  TIFFSetField(file, TIFFTAG_GEOTIEPOINTS, 6, corner.data());
  const std::unique_ptr<GTIF, void (*)(GTIF*)> keys(GTIFNew(file), GTIFFree);
  GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
  GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(keys.get(), ProjectedCSTypeGeoKey, TYPE_SHORT, 1, 32612);
  GTIFKeySet(keys.get(), ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  GTIFWriteKeys(keys.get());
}

/// The samples of one row of tiles, row by row from the north, as wide as whole tiles; beyond the
/// image its edge continues.
std::vector<float> tile_row(const SampleDem& sample, int first, int columns) {
  const auto width = static_cast<std::size_t>(columns) * tile;
  std::vector<float> pixels(width * tile);
  for (int j = 0; j < tile; ++j) {
    const auto row = sample_row(sample, std::max(sample.pixels - 1 - (first + j), 0));
    for (std::size_t i = 0; i < width; ++i) {
      pixels[static_cast<std::size_t>(j) * width + i] =
          static_cast<float>(row[std::min(i, row.size() - 1)]);
    }
  }
  return pixels;
}

void write_pixels(TIFF* file, const SampleDem& sample, const std::filesystem::path& path) {
  const int columns = (sample.pixels + tile - 1) / tile;
  const auto width = static_cast<std::size_t>(columns) * tile;
  std::vector<float> block(static_cast<std::size_t>(tile) * tile);
  for (int first = 0; first < sample.pixels; first += tile) {
    const auto pixels = tile_row(sample, first, columns);
    for (int column = 0; column < columns; ++column) {
      for (std::size_t j = 0; j < tile; ++j) {
        const auto from = pixels.begin() + static_cast<std::ptrdiff_t>(
                                               j * width + static_cast<std::size_t>(column) * tile);
        std::copy_n(from, tile, block.begin() + static_cast<std::ptrdiff_t>(j * tile));
      }
      const auto index = TIFFComputeTile(file, static_cast<std::uint32_t>(column) * tile,
                                         static_cast<std::uint32_t>(first), 0, 0);
      const auto bytes = static_cast<tmsize_t>(block.size() * sizeof(float));
      if (TIFFWriteEncodedTile(file, index, block.data(), bytes) != bytes) fail(path);
    }
  }
}

}  // namespace

std::vector<double> sample_row(const SampleDem& sample, int row) {
  const double y = (row + 0.5) * sample.spacing;
  const Waves waves(sample, y);
  std::vector<double> heights(static_cast<std::size_t>(sample.pixels));
  for (std::size_t i = 0; i < heights.size(); ++i) {
    heights[i] = elevation((static_cast<double>(i) + 0.5) * sample.spacing, y, waves, i);
  }
  return heights;
}

void write_sample_dem(const std::filesystem::path& path, const SampleDem& sample) {
  if (sample.pixels < 1 || sample.pixels > 65536) {
    throw Error(Fault::bad_input, "pixels",
                fmt::format("must be in [1, 65536], got {}", sample.pixels));
  }
  if (!(sample.spacing >= 1e-3 && sample.spacing <= 1e4)) {
    throw Error(Fault::bad_input, "spacing",
                fmt::format("must be in [0.001, 10000] m, got {}", sample.spacing));
  }
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  auto part = path;
  part += ".part";
  // BigTIFF from 2 GiB of samples on.
  const bool big = sample.pixels > 23'000;
  std::unique_ptr<TIFF, void (*)(TIFF*)> file(XTIFFOpen(part.c_str(), big ? "w8" : "w"),
                                              XTIFFClose);
  if (!file) fail(path);
  try {
    write_tags(file.get(), sample);
    write_pixels(file.get(), sample, path);
    if (TIFFFlush(file.get()) == 0) fail(path);
  } catch (...) {
    file.reset();
    std::filesystem::remove(part, error);
    throw;
  }
  file.reset();
  std::filesystem::rename(part, path, error);
  if (error) fail(path);
}

}  // namespace hoodoo::scene
