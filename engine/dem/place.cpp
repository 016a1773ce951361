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

// Universal Transverse Mercator on WGS 84 of the centre's zone, Universal Polar Stereographic
// beyond its ends.
std::string metric_crs(const RasterInfo& info) {
  auto centre =
      corner(info, 0.5 * static_cast<double>(info.width), 0.5 * static_cast<double>(info.height));
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
  // To a millionth of a degree: a centre on the border of two zones falls to one of them
  // everywhere.
  const auto rounded = [](double v) { return std::floor(v * 1e6 + 0.5) / 1e6; };
  const double latitude = rounded(degrees->y);
  double longitude = rounded(degrees->x);
  longitude -= 360 * std::floor((longitude + 180) / 360);
  if (latitude > 84) return "EPSG:5041";
  if (latitude < -80) return "EPSG:5042";
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
    spacing = rounded_spacing(std::min(size[0], size[1]));
  }
  const auto box = footprint(info, frame);
  frame.origin_x = std::floor(box.min_x / *spacing) * *spacing;
  frame.origin_y = std::floor(box.min_y / *spacing) * *spacing;
  return {frame, *spacing};
}

}  // namespace hoodoo::dem
