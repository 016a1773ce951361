#include "engine/dem/tiff.hpp"

#include <fmt/format.h>
#include <geotiff.h>
#include <geotiffio.h>
#include <xtiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <mutex>
#include <system_error>
#include <utility>

namespace hoodoo::dem {
namespace {

TIFFExtendProc next_extender = nullptr;

// libtiff hands out only tags that it was told of before the file is opened.
void add_gdal_tags(TIFF* tiff) {
  static char nodata[] = "GDALNoDataValue";
  static const TIFFFieldInfo fields[] = {
      {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, nodata},
  };
  TIFFMergeFieldInfo(tiff, fields, std::size(fields));
  if (next_extender) next_extender(tiff);
}

void register_tags_once() {
  static std::once_flag once;
  std::call_once(once, [] {
    next_extender = TIFFSetTagExtender(add_gdal_tags);
    XTIFFInitialize();
  });
}

int keep_message(TIFF*, void* kept, const char* module, const char* format, va_list arguments) {
  std::array<char, 512> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  auto& message = *static_cast<std::string*>(kept);
  message = module ? std::string(module) + ": " + text.data() : text.data();
  // A damaged file puts its own bytes into libtiff's messages.
  std::replace_if(
      message.begin(), message.end(),
      [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < 32 || byte > 126;
      },
      '?');
  return 1;  // handled: libtiff prints nothing
}

int drop_message(TIFF*, void*, const char*, const char*, va_list) { return 1; }

template <class T>
T field(TIFF* tiff, std::uint32_t tag, T fallback) {
  T value{};
  return TIFFGetFieldDefaulted(tiff, tag, &value) ? value : fallback;
}

Sample sample_of(const TiffFile& file, int bits, int format) {
  constexpr auto whole = std::array{8, 16, 32, 64};
  const auto size = std::find(whole.begin(), whole.end(), bits) - whole.begin();
  if (size < 4) {
    constexpr std::array unsigned_samples{Sample::uint8, Sample::uint16, Sample::uint32,
                                          Sample::uint64};
    constexpr std::array signed_samples{Sample::int8, Sample::int16, Sample::int32, Sample::int64};
    const auto at = static_cast<std::size_t>(size);
    if (format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID) return unsigned_samples[at];
    if (format == SAMPLEFORMAT_INT) return signed_samples[at];
    if (format == SAMPLEFORMAT_IEEEFP && bits == 32) return Sample::float32;
    if (format == SAMPLEFORMAT_IEEEFP && bits == 64) return Sample::float64;
  }
  const bool complex = format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP;
  throw file.error(Fault::bad_input,
                   fmt::format("has {}samples of {} bits (format {}); elevations are integers of "
                               "8, 16, 32 or 64 bits or floats of 32 or 64",
                               complex ? "complex " : "", bits, format));
}

void check_bands(const TiffFile& file) {
  const auto bands = field<std::uint16_t>(file.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
  if (bands != 1) {
    throw file.error(Fault::bad_input,
                     fmt::format("has {} bands; an elevation model has 1", bands));
  }
  const auto photometric =
      field<std::uint16_t>(file.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  if (photometric != PHOTOMETRIC_MINISBLACK && photometric != PHOTOMETRIC_MINISWHITE) {
    throw file.error(
        Fault::bad_input,
        fmt::format("holds colours (photometric interpretation {}), not elevations", photometric));
  }
}

void check_size(const TiffFile& file, const Layout& layout, const RasterLimits& limits) {
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (layout.width < 1 || layout.height < 1) {
    throw file.error(Fault::bad_input,
                     fmt::format("is {} x {} pixels", layout.width, layout.height));
  }
  if (layout.width > most || layout.height > most || layout.width > limits.pixels / layout.height) {
    throw file.error(Fault::limit, fmt::format("claims {} x {} pixels; the limit is {} in all",
                                               layout.width, layout.height, limits.pixels));
  }
}

void read_blocks(const TiffFile& file, Layout& layout, const RasterLimits& limits) {
  TIFF* const tiff = file.get();
  layout.tiled = TIFFIsTiled(tiff) != 0;
  if (layout.tiled) {
    layout.block_width = field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0);
    layout.block_height = field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH, 0);
  } else {
    layout.block_width = layout.width;
    layout.block_height =
        std::min<std::int64_t>(layout.height, field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP, 0));
  }
  if (layout.block_width < 1 || layout.block_height < 1) {
    throw file.error(Fault::bad_input, fmt::format("has blocks of {} x {} pixels",
                                                   layout.block_width, layout.block_height));
  }
  if (layout.block_width > limits.block_bytes / layout.sample_bytes / layout.block_height) {
    throw file.error(Fault::limit,
                     fmt::format("has blocks of {} x {} pixels of {} bytes; the limit is {} bytes",
                                 layout.block_width, layout.block_height, layout.sample_bytes,
                                 limits.block_bytes));
  }
  const auto blocks = layout.across() * layout.down();
  const auto listed =
      std::int64_t{layout.tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff)};
  // Each block takes at least two bytes in the table of offsets.
  if (listed != blocks || (blocks > 1 && static_cast<std::uintmax_t>(blocks) > file.bytes() / 2)) {
    throw file.error(Fault::bad_input,
                     fmt::format("claims {} blocks, more than a file of {} bytes can list", blocks,
                                 file.bytes()));
  }
}

}  // namespace

TiffFile::TiffFile(const std::filesystem::path& path, const RasterLimits& limits)
    : path_(path), state_(file_state(path)) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status))
    throw Error(Fault::not_found, path.string(), "is not there");
  if (!std::filesystem::is_regular_file(status)) {
    throw Error(Fault::bad_input, path.string(), "is not a file");
  }
  bytes_ = std::filesystem::file_size(path, failure);
  if (failure) throw Error(Fault::io, path.string(), "cannot be read: " + failure.message());

  register_tags_once();
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  // Room for one block as it lies in the file, which can be longer than decoded.
  TIFFOpenOptionsSetMaxSingleMemAlloc(
      options.get(), static_cast<tmsize_t>(limits.block_bytes + limits.block_bytes / 8 + 65536));
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_message, message_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), drop_message, nullptr);
  // "m": no memory mapping, so that a file cut short while it is read is an error, not a signal.
  tiff_.reset(TIFFOpenExt(path.c_str(), "rm", options.get()));
  if (!tiff_) throw error(Fault::bad_input, "is no readable TIFF");
}

Error TiffFile::error(Fault fault, std::string what) const {
  if (!message_->empty()) what += " (" + *message_ + ")";
  return Error(fault, path_.string(), std::move(what));
}

std::string to_string(Sample sample) {
  constexpr std::array names{"uint8", "int8",   "uint16", "int16",   "uint32",
                             "int32", "uint64", "int64",  "float32", "float64"};
  return names[static_cast<std::size_t>(sample)];
}

Layout read_layout(const TiffFile& file, const RasterLimits& limits) {
  TIFF* const tiff = file.get();
  Layout layout;
  layout.width = field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
  layout.height = field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
  check_size(file, layout, limits);
  check_bands(file);
  layout.photometric = field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  const int bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  const int format = field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  layout.sample = sample_of(file, bits, format);
  layout.sample_bytes = bits / 8;
  layout.compression = field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (!TIFFIsCODECConfigured(layout.compression)) {
    throw file.error(Fault::bad_input, fmt::format("is compressed by {}, which cannot be read here",
                                                   compression_name(layout.compression)));
  }
  // Asked of codecs without a predictor, libtiff answers nothing.
  std::uint16_t predictor = 1;
  if (TIFFGetField(tiff, TIFFTAG_PREDICTOR, &predictor)) layout.predictor = predictor;
  if (layout.predictor == PREDICTOR_FLOATINGPOINT && TIFFIsBigEndian(tiff)) {
    // libtiff 4.5.0 decodes it to garbage, and OpenImageIO and GDAL with it.
    throw file.error(Fault::bad_input,
                     "is big-endian with predictor 3, which libtiff decodes wrongly; write it "
                     "little-endian or with another predictor");
  }
  read_blocks(file, layout, limits);
  return layout;
}

std::string compression_name(std::uint16_t compression) {
  constexpr std::pair<int, const char*> names[] = {
      {COMPRESSION_NONE, "none"},       {COMPRESSION_LZW, "lzw"},
      {COMPRESSION_JPEG, "jpeg"},       {COMPRESSION_ADOBE_DEFLATE, "deflate"},
      {COMPRESSION_DEFLATE, "deflate"}, {COMPRESSION_PACKBITS, "packbits"},
      {COMPRESSION_LERC, "lerc"},       {COMPRESSION_LZMA, "lzma"},
      {COMPRESSION_ZSTD, "zstd"},       {COMPRESSION_WEBP, "webp"},
      {COMPRESSION_JP2000, "jpeg2000"}, {50002, "jpeg-xl"},
  };
  for (const auto& [code, name] : names) {
    if (code == compression) return name;
  }
  return fmt::format("method {}", compression);
}

}  // namespace hoodoo::dem
