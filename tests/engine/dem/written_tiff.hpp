#pragma once
#include <geotiff.h>
#include <geotiffio.h>
#include <unistd.h>
#include <xtiffio.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace hoodoo::dem {

/// A folder of its own for a test, gone when the test is over.
class ScratchFolder {
 public:
  ScratchFolder() {
    auto pattern = (std::filesystem::temp_directory_path() / "hoodoo-dem-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("no scratch folder");
    path_ = pattern;
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

struct TiffOptions {
  const char* mode = "w";  // "w8" BigTIFF, "wb" big-endian
  int tile = 0;            // side [pixels]; 0 is strips
  int rows_per_strip = 4;
  int compression = COMPRESSION_NONE;
  int predictor = 1;
  int bands = 1;
  int photometric = PHOTOMETRIC_MINISBLACK;
  std::string nodata = {};
  std::set<int> missing = {};                 // blocks never written
  std::vector<double> scale = {};             // ModelPixelScale
  std::vector<double> ties = {};              // ModelTiepoint
  std::vector<double> matrix = {};            // ModelTransformation
  std::function<void(GTIF*)> keys = nullptr;  // GeoTIFF keys
};

inline std::function<void(GTIF*)> utm(int epsg = 32632, int raster_type = RasterPixelIsArea) {
  return [=](GTIF* g) {
    GTIFKeySet(g, GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
    GTIFKeySet(g, GTRasterTypeGeoKey, TYPE_SHORT, 1, raster_type);
    GTIFKeySet(g, ProjectedCSTypeGeoKey, TYPE_SHORT, 1, epsg);
  };
}

inline std::function<void(GTIF*)> degrees(int epsg = 4326, int raster_type = RasterPixelIsArea) {
  return [=](GTIF* g) {
    GTIFKeySet(g, GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeGeographic);
    GTIFKeySet(g, GTRasterTypeGeoKey, TYPE_SHORT, 1, raster_type);
    GTIFKeySet(g, GeographicTypeGeoKey, TYPE_SHORT, 1, epsg);
  };
}

template <class T>
void write_blocks(TIFF* tiff, int width, int height, const std::vector<T>& samples,
                  const TiffOptions& o) {
  const int across = o.tile ? o.tile : width, down = o.tile ? o.tile : o.rows_per_strip;
  const auto row_values = static_cast<std::size_t>(across) * static_cast<std::size_t>(o.bands);
  int index = 0;
  for (int top = 0; top < height; top += down) {
    for (int left = 0; left < width; left += across, ++index) {
      if (o.missing.contains(index)) continue;
      const int rows = o.tile ? down : std::min(down, height - top);
      std::vector<T> block(row_values * static_cast<std::size_t>(rows));
      for (int j = 0; j < std::min(rows, height - top); ++j) {
        const int count = std::min(across, width - left) * o.bands;
        std::copy_n(samples.begin() + (top + j) * width * o.bands + left * o.bands, count,
                    block.begin() + j * static_cast<std::ptrdiff_t>(row_values));
      }
      const auto bytes = static_cast<tmsize_t>(block.size() * sizeof(T));
      const auto id = static_cast<std::uint32_t>(index);
      const auto put = o.tile ? TIFFWriteEncodedTile(tiff, id, block.data(), bytes)
                              : TIFFWriteEncodedStrip(tiff, id, block.data(), bytes);
      if (put < 0) throw std::runtime_error("a test TIFF could not be written");
    }
  }
}

inline void write_georeference(TIFF* tiff, const TiffOptions& o) {
  static char name[] = "GDALNoDataValue";
  static const TIFFFieldInfo nodata[] = {{42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name}};
  if (!TIFFFindField(tiff, 42113, TIFF_ANY)) TIFFMergeFieldInfo(tiff, nodata, 1);
  if (!o.nodata.empty()) TIFFSetField(tiff, 42113, o.nodata.c_str());
  const auto set = [&](std::uint32_t tag, const std::vector<double>& values) {
    if (!values.empty()) TIFFSetField(tiff, tag, static_cast<int>(values.size()), values.data());
  };
  set(TIFFTAG_GEOPIXELSCALE, o.scale);
  set(TIFFTAG_GEOTIEPOINTS, o.ties);
  set(TIFFTAG_GEOTRANSMATRIX, o.matrix);
  if (!o.keys) return;
  GTIF* const keys = GTIFNew(tiff);
  o.keys(keys);
  GTIFWriteKeys(keys);
  GTIFFree(keys);
}

/// Writes `samples` (row by row from the north, bands side by side) as a GeoTIFF.
template <class T>
std::filesystem::path write_tiff(const std::filesystem::path& path, int width, int height,
                                 const std::vector<T>& samples, const TiffOptions& o = {}) {
  TIFF* const tiff = XTIFFOpen(path.c_str(), o.mode);
  if (!tiff) throw std::runtime_error("a test TIFF could not be made");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, o.bands);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(T)));
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               std::is_floating_point_v<T> ? SAMPLEFORMAT_IEEEFP
               : std::is_signed_v<T>       ? SAMPLEFORMAT_INT
                                           : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, o.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, o.compression);
  if (o.predictor != 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, o.predictor);
  if (o.tile) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, o.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, o.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, o.rows_per_strip);
  }
  write_georeference(tiff, o);
  write_blocks(tiff, width, height, samples, o);
  XTIFFClose(tiff);
  return path;
}

}  // namespace hoodoo::dem
