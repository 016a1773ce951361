#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine/base/error.hpp"
#include "engine/dem/crs.hpp"
#include "engine/dem/dem.hpp"
#include "engine/dem/footprint.hpp"

namespace hoodoo::dem {
namespace {

Point centre_of(const RasterInfo& info) {
  return corner(info, 0.5 * static_cast<double>(info.width),
                0.5 * static_cast<double>(info.height));
}

Point degrees_at(const RasterInfo& info) {
  const auto centre = centre_of(info);
  std::optional<Point> degrees;
  try {
    degrees = Mapping(info.crs, "EPSG:4326", centre).forward(centre);
  } catch (const Error&) {
    degrees.reset();
  }
  if (!degrees || std::abs(degrees->y) > 90 || std::abs(degrees->x) > 1080) {
    throw Error(Fault::bad_input, info.path.string(),
                fmt::format("has its centre at {}, {} [{}], which is nowhere on Earth", centre.x,
                            centre.y, info.crs_name));
  }
  // To a millionth of a degree, so that a centre on the border of two zones falls to the same one
  // everywhere.
  const auto rounded = [](double v) { return std::floor(v * 1e6 + 0.5) / 1e6; };
  const double longitude = rounded(degrees->x);
  return {longitude - 360 * std::floor((longitude + 180) / 360), rounded(degrees->y)};
}

void check_extent(const RasterInfo& info, bool polar) {
  const auto& t = info.transform;
  const double degree = info.kind == RasterInfo::Crs::web_mercator ? 111319.490793 : 1;
  const auto width = static_cast<double>(info.width), height = static_cast<double>(info.height);
  const double across = (std::abs(t[1]) * width + std::abs(t[2]) * height) / degree;
  const double along = (std::abs(t[4]) * width + std::abs(t[5]) * height) / degree;
  if (along > 90 || (across > 90 && !polar)) {
    throw Error(Fault::bad_input, info.path.string(),
                fmt::format("covers {:.1f} x {:.1f} degrees; a scene is flat and holds 90 x 90",
                            across, along));
  }
}

// Universal Transverse Mercator on WGS 84 of the centre's zone, Universal Polar Stereographic
// beyond its ends.
std::string metric_crs(const RasterInfo& info) {
  const auto [longitude, latitude] = degrees_at(info);
  const bool polar = latitude > 84 || latitude < -80;
  check_extent(info, polar);
  if (polar) return latitude > 0 ? "EPSG:5041" : "EPSG:5042";
  const int zone = std::min(60, static_cast<int>((longitude + 180) / 6) + 1);
  return fmt::format("EPSG:{}", (latitude >= 0 ? 32600 : 32700) + zone);
}

}  // namespace

double step_of(double spacing) {
  assert(spacing > 0);
  int exponent = 0;
  std::frexp(spacing, &exponent);  // spacing in [2^(e-1), 2^e)
  return std::ldexp(1.0, exponent - 1 - 8);
}

double rounded_spacing(double spacing) {
  const double step = step_of(spacing);
  return std::max(256.0, std::floor(spacing / step + 0.5)) * step;
}

Placement place(const Raster& first, std::optional<double> spacing) {
  const auto& info = first.info();
  Frame frame;
  switch (info.kind) {
    case RasterInfo::Crs::none:
      break;
    case RasterInfo::Crs::projected:
      frame.crs = info.crs;
      frame.unit = info.unit;
      break;
    case RasterInfo::Crs::geographic:
    case RasterInfo::Crs::web_mercator:
      frame.crs = metric_crs(info);
      break;
  }
  if (!spacing) {
    const auto size = ground_size(info, frame);
    const double least = std::min(size[0], size[1]);
    if (!(least >= 1e-6 && least <= 1e7)) {
      throw Error(
          Fault::bad_input, info.path.string(),
          fmt::format("has pixels of {} x {} m; they must be in [1e-6, 1e7] m", size[0], size[1]));
    }
    spacing = rounded_spacing(least);
  }
  const auto box = footprint(info, frame);
  frame.origin_x = std::floor(box.min_x / *spacing) * *spacing;
  frame.origin_y = std::floor(box.min_y / *spacing) * *spacing;
  return {frame, *spacing};
}

}  // namespace hoodoo::dem
