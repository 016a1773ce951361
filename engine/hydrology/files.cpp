#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "engine/base/error.hpp"
#include "engine/base/math.hpp"
#include "engine/dem/raster.hpp"
#include "engine/hydrology/hydrology.hpp"
#include "engine/hydrology/raster_writer.hpp"
#include "engine/hydrology/row_sizes.hpp"

namespace hoodoo::hydrology {
namespace {

namespace fs = std::filesystem;

/// Ground size [m] of a cell one unit wide and high at northing `y` of the CRS.
struct Ground {
  double x, y;
};
/// On the ellipsoid of GRS 80 (as WGS 84 to 0.1 mm), by the radii of curvature of the meridian and
/// the prime vertical. Source: Snyder 1987, Map projections: a working manual, equations 4-18,
/// 4-20.
Ground of_a_degree(double latitude) {
  constexpr double a = 6'378'137, squared_eccentricity = 0.00669438002290;
  const double radians = latitude * pi / 180;
  const double s = bit_sin(radians), w = 1 - squared_eccentricity * s * s;
  const double root = std::sqrt(w);
  return {a / root * bit_cos(radians) * pi / 180,
          a * (1 - squared_eccentricity) / (w * root) * pi / 180};
}

Ground ground_of(const dem::RasterInfo& info, double y) {
  using Crs = dem::RasterInfo::Crs;
  if (info.kind == Crs::geographic) return of_a_degree(std::clamp(y, -89.999, 89.999));
  if (info.kind == Crs::web_mercator) {
    // Its scale is one over the cosine of the latitude: 2 / (e^v + e^-v).
    const double v = bit_exp(y * info.unit / 6'378'137);
    const double cosine = 2 / (v + 1 / v);
    return {info.unit * cosine, info.unit * cosine};
  }
  return {info.unit, info.unit};
}

}  // namespace

void set_row_sizes(Grid& grid, const dem::RasterInfo& info) {
  const auto& t = info.transform;
  for (std::int32_t j = 0; j < grid.height; ++j) {
    const double y = t[3] + t[4] * (0.5 * grid.width) + t[5] * (j + 0.5);
    const auto unit = ground_of(info, y);
    const auto length = [&](double x, double north) {
      const double east = x * unit.x, up = north * unit.y;
      return std::sqrt(east * east + up * up);
    };
    grid.dx.push_back(length(t[1], t[4]));
    grid.dy.push_back(length(t[2], t[5]));
  }
}

Grid read(const fs::path& dem, const FileLimits& limits) {
  const auto raster = dem::Raster::open(dem);
  const auto& info = raster->info();
  const auto most = static_cast<std::int64_t>(limits.memory / bytes_per_cell);
  if (info.width > most / std::max<std::int64_t>(info.height, 1) ||
      info.width * info.height > std::numeric_limits<std::int32_t>::max()) {
    throw Error(Fault::limit, dem.string(),
                fmt::format("has {} x {} pixels; {} MiB of memory do for {}", info.width,
                            info.height, limits.memory >> 20, most));
  }
  Grid grid;
  grid.width = static_cast<std::int32_t>(info.width);
  grid.height = static_cast<std::int32_t>(info.height);
  set_row_sizes(grid, info);
  grid.z.reserve(static_cast<std::size_t>(info.width * info.height));
  std::vector<double> row;
  for (std::int32_t j = 0; j < grid.height; ++j) {
    raster->read(0, j, grid.width, 1, row);
    for (const double z : row) grid.z.push_back(static_cast<float>(z * info.vertical_unit));
  }
  return grid;
}

void write(const fs::path& file, const fs::path& dem, const Grid& grid,
           std::span<const float> values) {
  RasterWriter writer(file, dem, grid.width, grid.height);
  writer.append(values);
  writer.commit();
}

}  // namespace hoodoo::hydrology
