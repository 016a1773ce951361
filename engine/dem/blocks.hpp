#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "engine/dem/tiff.hpp"

namespace hoodoo::dem {

/// Decodes the blocks of one raster. For one thread at a time.
class BlockReader {
 public:
  virtual ~BlockReader() = default;
  /// The samples of block (column, row) in the byte order of the machine, row by row.
  /// `out` holds layout.block_bytes(); what lies past the last row of the raster is left as it was.
  /// Errors: bad_input naming the file and the pixels, of a block that cannot be decoded; io,
  /// of one that the system cannot read.
  virtual void read(std::int64_t column, std::int64_t row, std::span<std::byte> out) = 0;
};

/// By OpenImageIO, or by libtiff for what OpenImageIO does not read faithfully. `file` outlives it.
std::unique_ptr<BlockReader> block_reader(const TiffFile& file, const Layout& layout);

/// False for a block that a sparse file leaves out.
bool has_block(const TiffFile& file, const Layout& layout, std::int64_t column, std::int64_t row);

}  // namespace hoodoo::dem
