#include "engine/hydrology/raster_writer.hpp"

#include <geotiffio.h>
#include <xtiffio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <initializer_list>
#include <string>
#include <system_error>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/dem/tiff.hpp"

namespace hoodoo::hydrology {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t tile_side = 256;
constexpr ttag_t gdal_nodata = 42113;

/// After what libtiff could not do, which leaves the system's reason.
Error failed(const fs::path& file) {
  const int why = errno;
  return {Fault::io, file.string(),
          "cannot be written" +
              (why == 0 ? std::string() : ": " + std::generic_category().message(why))};
}

void declare_nodata(TIFF* file) {
  static char name[] = "GDALNoDataValue";
  static const std::array<TIFFFieldInfo, 1> fields{
      {{gdal_nodata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name}}};
  TIFFMergeFieldInfo(file, fields.data(), fields.size());
}

/// Where the raster lies, word for word: the tags of its source.
void copy_place(TIFF* from, TIFF* to) {
  for (const ttag_t tag :
       std::initializer_list<ttag_t>{TIFFTAG_GEOPIXELSCALE, TIFFTAG_GEOTIEPOINTS,
                                     TIFFTAG_GEOTRANSMATRIX, TIFFTAG_GEODOUBLEPARAMS}) {
    std::uint16_t count = 0;
    double* values = nullptr;
    if (TIFFGetField(from, tag, &count, &values) == 1) TIFFSetField(to, tag, count, values);
  }
  std::uint16_t count = 0;
  std::uint16_t* keys = nullptr;
  if (TIFFGetField(from, TIFFTAG_GEOKEYDIRECTORY, &count, &keys) == 1) {
    TIFFSetField(to, TIFFTAG_GEOKEYDIRECTORY, count, keys);
  }
  char* text = nullptr;
  if (TIFFGetField(from, TIFFTAG_GEOASCIIPARAMS, &text) == 1) {
    TIFFSetField(to, TIFFTAG_GEOASCIIPARAMS, text);
  }
}

void write_layout(TIFF* file, std::size_t width, std::size_t height) {
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(width));
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(height));
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(file, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
  TIFFSetField(file, TIFFTAG_TILEWIDTH, static_cast<std::uint32_t>(tile_side));
  TIFFSetField(file, TIFFTAG_TILELENGTH, static_cast<std::uint32_t>(tile_side));
  TIFFSetField(file, gdal_nodata, "nan");
}

}  // namespace

struct RasterWriter::File {
  explicit File(fs::path file) : path(std::move(file)), writer(path), tiff(nullptr, XTIFFClose) {}

  fs::path path;
  FileWriter writer;
  std::unique_ptr<TIFF, void (*)(TIFF*)> tiff;
};

RasterWriter::RasterWriter(fs::path file, const fs::path& place, std::int64_t width,
                           std::int64_t height)
    : file_(std::make_unique<File>(std::move(file))),
      width_(static_cast<std::size_t>(width)),
      height_(static_cast<std::size_t>(height)) {
  const dem::TiffFile source(place, {});
  const bool big = width_ * height_ > std::size_t{1} << 29;  // BigTIFF from 2 GiB on
  file_->tiff.reset(XTIFFOpen(file_->writer.temporary().c_str(), big ? "w8" : "w"));
  if (!file_->tiff) throw failed(file_->path);
  declare_nodata(file_->tiff.get());
  write_layout(file_->tiff.get(), width_, height_);
  copy_place(source.get(), file_->tiff.get());
  waiting_.reserve(width_ * std::min(height_, tile_side));
}

RasterWriter::~RasterWriter() = default;

void RasterWriter::append(std::span<const float> rows) {
  while (!rows.empty()) {
    const auto room = width_ * std::min(height_ - written_, tile_side) - waiting_.size();
    const auto part = rows.first(std::min(rows.size(), room));
    waiting_.insert(waiting_.end(), part.begin(), part.end());
    rows = rows.subspan(part.size());
    if (part.size() == room) write_tiles();
  }
}

/// Tiles reach beyond the raster; there they repeat its last column and row.
void RasterWriter::write_tiles() {
  const auto high = waiting_.size() / width_;
  std::vector<float> tile(tile_side * tile_side);
  for (std::size_t x = 0; x < width_; x += tile_side) {
    for (std::size_t j = 0; j < tile_side; ++j) {
      const float* row = waiting_.data() + std::min(j, high - 1) * width_;
      for (std::size_t i = 0; i < tile_side; ++i) {
        tile[tile_side * j + i] = row[std::min(x + i, width_ - 1)];
      }
    }
    const auto bytes = static_cast<tmsize_t>(tile.size() * sizeof(float));
    const auto number = TIFFComputeTile(file_->tiff.get(), static_cast<std::uint32_t>(x),
                                        static_cast<std::uint32_t>(written_), 0, 0);
    if (TIFFWriteEncodedTile(file_->tiff.get(), number, tile.data(), bytes) != bytes) {
      throw failed(file_->path);
    }
  }
  written_ += high;
  waiting_.clear();
}

void RasterWriter::commit() {
  if (TIFFFlush(file_->tiff.get()) == 0) throw failed(file_->path);
  file_->writer.commit();
}

}  // namespace hoodoo::hydrology
