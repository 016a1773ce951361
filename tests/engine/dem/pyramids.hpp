#pragma once
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "engine/base/hash.hpp"
#include "engine/dem/dem.hpp"
#include "tests/engine/dem/written_tiff.hpp"

/// Rasters that are written for a test, and the pyramids that come of them.
namespace hoodoo::dem {

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

inline std::vector<float> hills(int width, int height, double holes = 0) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<float> samples;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const double h =
          300 + 40 * std::sin(i * 0.05) + 60 * std::cos(j * 0.031 + i * 0.01) + 3 * part(random);
      samples.push_back(part(random) < holes ? nan : static_cast<float>(h));
    }
  }
  return samples;
}

inline std::filesystem::path projected(const ScratchFolder& folder, int width, int height,
                                       const std::vector<float>& samples, double scale = 2) {
  TiffOptions o;
  o.scale = {scale, scale, 0};
  o.ties = {0, 0, 0, 500001, 5000001, 0};
  o.keys = utm();
  return write_tiff(folder / "projected.tif", width, height, samples, o);
}

inline std::filesystem::path geographic(const ScratchFolder& folder, int width, int height,
                                        const std::vector<float>& samples) {
  TiffOptions o;
  o.scale = {1 / 3600.0, 1 / 3600.0, 0};
  o.ties = {0, 0, 0, 8.2, 46.7, 0};
  o.keys = degrees();
  o.compression = COMPRESSION_ADOBE_DEFLATE;
  return write_tiff(folder / "geographic.tif", width, height, samples, o);
}

inline std::shared_ptr<const Pyramid> ingest(const std::filesystem::path& path,
                                             const std::filesystem::path& folder,
                                             std::optional<double> fill = {},
                                             const IngestSettings& settings = {}) {
  const auto placed = place(*Raster::open(path), {});
  return Pyramid::ingest(path, placed.frame, placed.spacing, fill, folder, settings);
}

inline Box area(double x0, double y0, double x1, double y1) { return {{x0, y0, 0}, {x1, y1, 0}}; }

/// File name -> digest of what is in it, for the finished pyramid in `folder`.
inline std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  std::map<std::string, std::string> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".lock") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    found[std::filesystem::relative(entry.path(), folder).string()] = sha256(bytes).hex();
  }
  return found;
}

}  // namespace hoodoo::dem
