#include "tiling/export/image.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <geotiffio.h>
#include <xtiffio.h>

#include <array>
#include <charconv>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

Error failed(const fs::path& file, const std::string& why = {}) {
  return {Fault::io, file.string(), "cannot be written" + (why.empty() ? "" : ": " + why)};
}

class Png final : public Rows {
 public:
  Png(const fs::path& file, const Canvas& canvas)
      : path_(file),
        file_(file),
        output_(OIIO::ImageOutput::create("png")),
        width_(static_cast<std::size_t>(canvas.width)),
        left_(canvas.height) {
    if (!output_) throw Error(Fault::internal, file.string(), "OpenImageIO has no PNG");
    const OIIO::ImageSpec spec(static_cast<int>(canvas.width), static_cast<int>(canvas.height), 1,
                               OIIO::TypeDesc::UINT16);
    if (!output_->open(file_.temporary().string(), spec)) {
      throw failed(path_, output_->geterror());
    }
  }
  /// A file that is given up is filled first: libpng writes to stderr when rows are missing.
  ~Png() override {
    const std::vector<std::uint16_t> blank(width_);
    while (left_ > 0 && write(blank)) {
    }
  }
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;

  void add(std::span<const std::uint16_t> row) override {
    if (!write(row)) throw failed(path_, output_->geterror());
  }
  void finish() override {
    if (!output_->close()) throw failed(path_, output_->geterror());
    file_.commit();
  }

 private:
  bool write(std::span<const std::uint16_t> row) {
    --left_;
    return output_->write_scanline(next_++, 0, OIIO::TypeDesc::UINT16, row.data());
  }

  fs::path path_;
  FileWriter file_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  std::size_t width_;
  std::int64_t left_;  // rows
  int next_ = 0;
};

/// Fields that GDAL adds to TIFF: an XML of scale and offset, and the value of no data.
constexpr ttag_t gdal_metadata = 42112, gdal_nodata = 42113;

void declare_fields(TIFF* file) {
  static char metadata[] = "GDALMetadata", nodata[] = "GDALNoDataValue";
  static const std::array<TIFFFieldInfo, 2> fields{
      {{gdal_metadata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, metadata},
       {gdal_nodata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, nodata}}};
  TIFFMergeFieldInfo(file, fields.data(), fields.size());
}

void write_keys(TIFF* file, const dem::Frame& frame) {
  const std::unique_ptr<GTIF, void (*)(GTIF*)> keys(GTIFNew(file), GTIFFree);
  GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  constexpr std::string_view authority = "EPSG:";
  unsigned code = 0;
  if (frame.crs.starts_with(authority)) {
    const auto* end = frame.crs.data() + frame.crs.size();
    const auto read = std::from_chars(frame.crs.data() + authority.size(), end, code);
    if (read.ptr != end || code > 32767) code = 0;
  }
  if (!frame.crs.empty()) {
    GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
    GTIFKeySet(keys.get(), ProjectedCSTypeGeoKey, TYPE_SHORT, 1,
               code > 0 ? static_cast<int>(code) : KvUserDefined);
    // Without a code, a reader has the CRS's text at least.
    if (code == 0) {
      GTIFKeySet(keys.get(), PCSCitationGeoKey, TYPE_ASCII, static_cast<int>(frame.crs.size()),
                 frame.crs.c_str());
    }
  }
  GTIFWriteKeys(keys.get());
}

class Tif final : public Rows {
 public:
  Tif(const fs::path& file, const Canvas& canvas, const dem::Frame& frame)
      : path_(file), file_(file), tiff_(nullptr, XTIFFClose) {
    // BigTIFF from 2 GiB of samples on.
    const bool big = canvas.width * canvas.height > std::int64_t{1} << 30;
    tiff_.reset(XTIFFOpen(file_.temporary().c_str(), big ? "w8" : "w"));
    if (!tiff_) throw failed(path_);
    declare_fields(tiff_.get());
    write_layout(canvas);
    write_place(canvas, frame);
    write_keys(tiff_.get(), frame);
  }
  void add(std::span<const std::uint16_t> row) override {
    std::vector<std::uint16_t> copy(row.begin(), row.end());  // the predictor works in place
    if (TIFFWriteScanline(tiff_.get(), copy.data(), next_++, 0) < 0) throw failed(path_);
  }
  void finish() override {
    if (TIFFFlush(tiff_.get()) == 0) throw failed(path_);
    tiff_.reset();
    file_.commit();
  }

 private:
  void write_layout(const Canvas& canvas) {
    auto* file = tiff_.get();
    TIFFSetField(file, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(canvas.width));
    TIFFSetField(file, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(canvas.height));
    TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(file, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(file, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
    TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(file, 0));
  }

  /// The north-west corner and the size of pixels, in units of the CRS.
  void write_place(const Canvas& canvas, const dem::Frame& frame) {
    auto* file = tiff_.get();
    const double side = canvas.pixel / frame.unit;
    const auto at = [&](double origin, std::int64_t pixels) {
      return (origin + static_cast<double>(pixels) * canvas.pixel) / frame.unit;
    };
    const std::array<double, 3> scale{side, side, 0};
    const std::array<double, 6> corner{
        0, 0, 0, at(frame.origin_x, canvas.x), at(frame.origin_y, canvas.y + canvas.height), 0};
    TIFFSetField(file, TIFFTAG_GEOPIXELSCALE, 3, scale.data());
    TIFFSetField(file, TIFFTAG_GEOTIEPOINTS, 6, corner.data());
    const auto scaling = fmt::format(
        "<GDALMetadata>\n"
        "  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">{}</Item>\n"
        "  <Item name=\"SCALE\" sample=\"0\" role=\"scale\">{}</Item>\n"
        "</GDALMetadata>\n",
        canvas.offset, canvas.scale);
    TIFFSetField(file, gdal_metadata, scaling.c_str());
    TIFFSetField(file, gdal_nodata, "0");
  }

  fs::path path_;
  FileWriter file_;
  std::unique_ptr<TIFF, void (*)(TIFF*)> tiff_;
  std::uint32_t next_ = 0;
};

}  // namespace

std::unique_ptr<Rows> open_png(const fs::path& file, const Canvas& canvas) {
  return std::make_unique<Png>(file, canvas);
}
std::unique_ptr<Rows> open_tif(const fs::path& file, const Canvas& canvas,
                               const dem::Frame& frame) {
  return std::make_unique<Tif>(file, canvas, frame);
}

}  // namespace hoodoo::exporting
