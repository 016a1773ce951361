#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace hoodoo::hydrology {

/// Writes a deflated GeoTIFF of tiles of 256^2 floats row by row, in the place of another raster of
/// the same size. A reader sees the whole file or none.
///
/// Holds 256 rows. Errors: io naming the file.
class RasterWriter {
 public:
  RasterWriter(std::filesystem::path file, const std::filesystem::path& place, std::int64_t width,
               std::int64_t height);
  ~RasterWriter();
  RasterWriter(const RasterWriter&) = delete;
  RasterWriter& operator=(const RasterWriter&) = delete;

  /// The next rows, all of them whole.
  void append(std::span<const float> rows);
  /// After the last row.
  void commit();

 private:
  struct File;
  void write_tiles();

  std::unique_ptr<File> file_;
  std::size_t width_, height_, written_ = 0;
  std::vector<float> waiting_;
};

}  // namespace hoodoo::hydrology
