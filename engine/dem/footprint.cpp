#include "engine/dem/footprint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/base/error.hpp"

namespace hoodoo::dem {
namespace {

double rounded(double metres) { return std::floor(metres * 1024 + 0.5) / 1024; }

Error beyond(const RasterInfo& info, const Frame& frame, const Point& p) {
  return Error(Fault::bad_input, info.path.string(),
               fmt::format("reaches {}, {} [{}], which cannot be mapped to {}", p.x, p.y,
                           info.crs_name, frame.crs));
}

/// Points of the raster in metres of the frame's CRS.
class Placed {
 public:
  Placed(const RasterInfo& info, const Frame& frame)
      : info_(info), frame_(frame), mapping_(mapping(info, frame)) {}

  Point at(double i, double j) const {
    auto p = corner(info_, i, j);
    if (!mapping_) return {p.x * frame_.unit, p.y * frame_.unit};
    // A border of pixels centred on the pole reaches half a pixel beyond it.
    if (info_.kind == RasterInfo::Crs::geographic && std::abs(p.y) < 92) {
      p.y = std::clamp(p.y, -90.0, 90.0);
    }
    const auto q = mapping_->forward(p);
    if (!q) throw beyond(info_, frame_, p);
    return {rounded(q->x * frame_.unit), rounded(q->y * frame_.unit)};
  }

 private:
  const RasterInfo& info_;
  const Frame& frame_;
  std::optional<Mapping> mapping_;
};

}  // namespace

bool aligned(const RasterInfo& info, const Frame& frame) {
  return info.transform[2] == 0 && info.transform[4] == 0 && same_crs(info.crs, frame.crs);
}

std::optional<Mapping> mapping(const RasterInfo& info, const Frame& frame) {
  if (same_crs(info.crs, frame.crs)) return std::nullopt;
  if (info.crs.empty() || frame.crs.empty()) {
    throw Error(Fault::bad_input, info.path.string(),
                info.crs.empty() ? fmt::format("states no coordinate system, so it cannot be laid "
                                               "into the scene's {}",
                                               frame.crs)
                                 : fmt::format("states {}, but the scene's frame, taken from its "
                                               "first terrain, has no coordinate system",
                                               info.crs_name));
  }
  try {
    return Mapping(info.crs, frame.crs,
                   corner(info, 0.5 * static_cast<double>(info.width),
                          0.5 * static_cast<double>(info.height)));
  } catch (const Error& error) {
    throw Error(error.fault, info.path.string(), error.problems.front().what);
  }
}

Rectangle footprint(const RasterInfo& info, const Frame& frame) {
  const Placed placed(info, frame);
  constexpr auto far = std::numeric_limits<double>::infinity();
  Rectangle box{far, far, -far, -far};
  const auto add = [&](double i, double j) {
    const auto p = placed.at(i, j);
    box = {std::min(box.min_x, p.x), std::min(box.min_y, p.y), std::max(box.max_x, p.x),
           std::max(box.max_y, p.y)};
  };
  const auto width = static_cast<double>(info.width), height = static_cast<double>(info.height);
  // Between two of these points a border of a degree bulges by less than a pixel's hundredth.
  constexpr int steps = 256;
  for (int k = 0; k <= steps; ++k) {
    const double along = k / static_cast<double>(steps);
    add(along * width, 0);
    add(along * width, height);
    add(0, along * height);
    add(width, along * height);
  }
  return box;
}

std::array<double, 2> ground_size(const RasterInfo& info, const Frame& frame) {
  const Placed placed(info, frame);
  // Over some pixels, so that rounding to 2^-10 m does not show.
  const double i = 0.5 * static_cast<double>(info.width);
  const double j = 0.5 * static_cast<double>(info.height);
  const double across = std::min(i, 64.0), down = std::min(j, 64.0);
  const auto distance = [](const Point& a, const Point& b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
  };
  return {distance(placed.at(i - across, j), placed.at(i + across, j)) / (2 * across),
          distance(placed.at(i, j - down), placed.at(i, j + down)) / (2 * down)};
}

}  // namespace hoodoo::dem
