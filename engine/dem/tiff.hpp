#pragma once
#include <tiffio.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "engine/base/error.hpp"
#include "engine/dem/raster.hpp"

namespace hoodoo::dem {

/// The first directory of a TIFF, read through libtiff. What libtiff has to say is kept for the
/// errors instead of being printed. For one thread at a time.
class TiffFile {
 public:
  /// Errors: not_found, io, bad_input.
  TiffFile(const std::filesystem::path& path, const RasterLimits& limits);

  TIFF* get() const { return tiff_.get(); }
  const std::filesystem::path& path() const { return path_; }
  std::uintmax_t bytes() const { return bytes_; }
  /// From before it was opened.
  const std::optional<FileState>& state() const { return state_; }
  /// An error naming the file, with libtiff's last message if it left one.
  Error error(Fault fault, std::string what) const;

 private:
  struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  };
  std::filesystem::path path_;
  std::optional<FileState> state_;
  std::uintmax_t bytes_ = 0;
  // On the heap: libtiff keeps its address while TiffFile moves.
  std::unique_ptr<std::string> message_ = std::make_unique<std::string>();
  std::unique_ptr<TIFF, Close> tiff_;
};

enum class Sample { uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64 };
std::string to_string(Sample sample);

/// How the pixels lie in the file: blocks of equal size, row by row, the last ones cut short.
struct Layout {
  std::int64_t width = 0, height = 0;
  bool tiled = false;
  std::int64_t block_width = 0, block_height = 0;  // a strip is as wide as the raster
  Sample sample = Sample::uint8;
  int sample_bytes = 1;
  std::uint16_t compression = 1, predictor = 1, photometric = 1;

  std::int64_t across() const { return (width + block_width - 1) / block_width; }
  std::int64_t down() const { return (height + block_height - 1) / block_height; }
  std::size_t block_bytes() const {
    return static_cast<std::size_t>(block_width * block_height * sample_bytes);
  }
};

/// Errors: bad_input for whatever is not one band of plain elevations, limit.
Layout read_layout(const TiffFile& file, const RasterLimits& limits);

/// "deflate", "lzw" ...; "method 12345" for one without a name here.
std::string compression_name(std::uint16_t compression);

}  // namespace hoodoo::dem
