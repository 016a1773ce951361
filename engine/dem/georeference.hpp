#pragma once
#include "engine/dem/tiff.hpp"

namespace hoodoo::dem {

/// Reads where the raster lies: fills nodata, pixel_is_point, transform, kind, crs, crs_name, unit
/// and vertical_unit of `info`, whose width and height are known.
/// Errors: bad_input for a transform that is not invertible or a CRS that PROJ cannot use.
void read_georeference(const TiffFile& file, RasterInfo& info);

}  // namespace hoodoo::dem
