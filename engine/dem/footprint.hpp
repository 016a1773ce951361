#pragma once
#include <optional>

#include "engine/dem/crs.hpp"
#include "engine/dem/dem.hpp"

namespace hoodoo::dem {

/// True where the samples of the raster can be taken as they are: its CRS is the frame's, and its
/// rows and columns run along the axes.
bool aligned(const RasterInfo& info, const Frame& frame);

/// From the raster's CRS to the frame's; nothing where they are the same or neither has one.
/// Errors: bad_input naming the file where one has a CRS and the other has none, or PROJ knows no
/// way between them.
std::optional<Mapping> mapping(const RasterInfo& info, const Frame& frame);

/// Where pixel corner (i, j) of the file lies, in units of the raster's CRS.
inline Point corner(const RasterInfo& info, double i, double j) {
  const auto& t = info.transform;
  return {t[0] + t[1] * i + t[2] * j, t[3] + t[4] * i + t[5] * j};
}

/// A rectangle of the frame's CRS [m], before the origin is subtracted.
struct Rectangle {
  double min_x, min_y, max_x, max_y;
};

/// The smallest rectangle around the raster's border, rounded to 2^-10 m where PROJ had a part in
/// it: the last bits of PROJ's results are the C library's.
/// Errors: bad_input where the border cannot be mapped.
Rectangle footprint(const RasterInfo& info, const Frame& frame);

/// Ground size of a pixel at the raster's centre, along its rows and its columns [m].
std::array<double, 2> ground_size(const RasterInfo& info, const Frame& frame);

}  // namespace hoodoo::dem
