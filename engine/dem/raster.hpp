#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/file.hpp"

namespace hoodoo::dem {

/// What is refused before memory is spent.
struct RasterLimits {
  std::int64_t pixels = std::int64_t{1} << 36;  // of the whole raster
  std::int64_t block_bytes = 256 << 20;         // of one strip or tile, decoded
};

/// What a GeoTIFF says of itself.
struct RasterInfo {
  std::filesystem::path path;
  std::optional<FileState> state;      // before it was opened
  std::int64_t width = 0, height = 0;  // pixels; row 0 is the first in the file
  std::string sample;                  // "int16", "float32" ...
  std::string layout;                  // "striped 8 rows", "tiled 256 x 256"
  std::string compression;             // "none", "deflate", "lzw", "zstd" ...
  int predictor = 1;
  bool big = false;              // BigTIFF
  std::optional<double> nodata;  // the GDAL_NODATA tag, as a number (NaN too)
  bool pixel_is_point = false;
  // x = t[0] + t[1] i + t[2] j, y = t[3] + t[4] i + t[5] j for pixel CORNERS (i, j), in units of
  // the CRS; pixel-is-point is already moved by half a pixel.
  std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
  enum class Crs { none, geographic, projected, web_mercator } kind = Crs::none;
  std::string crs;           // PROJ definition: "EPSG:4326", or WKT2 of a CRS given by parameters
  std::string crs_name;      // for people
  double unit = 1;           // metres per unit, projected only
  double vertical_unit = 1;  // metres per unit of the samples, by the vertical units key
  std::string vertical;      // what they count from: "ellipsoid", a vertical CRS, "" if not told
};
nlohmann::json to_json(const RasterInfo& info);

/// An open GeoTIFF of one elevation band. One object per thread.
class Raster {
 public:
  /// Opens and checks. Errors name the file: not_found, io, bad_input (no TIFF, more than one
  /// band, complex or unreadable samples, a transform that is not invertible), limit.
  static std::unique_ptr<Raster> open(const std::filesystem::path& path,
                                      const RasterLimits& limits = {});
  virtual ~Raster() = default;
  virtual const RasterInfo& info() const = 0;
  /// Pixels [i0, i0+width) x [j0, j0+height) in file order, NaN where there is no data (by tag, by
  /// NaN, infinite, beyond 1e30, or in a block that a sparse file leaves out), in units of the
  /// file. The rectangle lies inside the raster. Errors: io naming the file; bad_input when it is
  /// cut short.
  virtual void read(std::int64_t i0, std::int64_t j0, int width, int height,
                    std::vector<double>& out) = 0;
  /// Keeps up to `bytes` of decoded blocks, but at least one, between reads; else 16 MiB.
  virtual void keep(std::size_t bytes) = 0;
  /// Bytes of one decoded strip or tile, and its size in pixels.
  struct Block {
    std::size_t bytes;
    std::int64_t width, height;
  };
  virtual Block block() const = 0;
};

}  // namespace hoodoo::dem
