#pragma once
#include <memory>
#include <span>

#include "engine/dem/dem.hpp"
#include "tiling/export/formats.hpp"

namespace hoodoo::exporting {

/// A height map as it is written, row by row from the north.
class Rows {
 public:
  virtual ~Rows() = default;
  virtual void add(std::span<const std::uint16_t> row) = 0;
  virtual void finish() = 0;
};

/// PNG by OpenImageIO; deflated TIFF with GeoTIFF keys, and offset, scale and NoData as GDAL writes
/// them. Errors of all members: io, naming the file.
std::unique_ptr<Rows> open_png(const std::filesystem::path& file, const Canvas& canvas);
std::unique_ptr<Rows> open_tif(const std::filesystem::path& file, const Canvas& canvas,
                               const dem::Frame& frame);

}  // namespace hoodoo::exporting
