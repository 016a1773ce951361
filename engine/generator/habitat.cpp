#include "engine/generator/habitat.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/math.hpp"
#include "engine/hydrology/hydrology.hpp"
#include "engine/tree/polygon.hpp"

namespace hoodoo::generator {
namespace {

/// Rise over run of a slope [deg]; from here to the vertical there is no greater one.
double rise(double degrees) {
  constexpr double vertical = 89.9;
  if (degrees >= vertical) return Box::infinity;
  const double radians = std::max(degrees, 0.0) * (pi / 180);
  return bit_sin(radians) / bit_cos(radians);
}

double smooth(double u) {
  const double t = std::clamp(u, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// 1 from b to c, 0 below a and above d.
double trapezoid(double v, double a, double b, double c, double d) {
  if (v < b) return b > a ? smooth((v - a) / (b - a)) : 0;
  if (v > c) return d > c && std::isfinite(d) ? smooth((d - v) / (d - c)) : std::isinf(d) ? 1 : 0;
  return 1;
}

double slope_fit(double slope, const SlopeRange& range) {
  const double low = range.low - range.falloff;
  return trapezoid(slope, low > 0 ? rise(low) : -1, rise(range.low), rise(range.high),
                   rise(range.high + range.falloff));
}

/// The elevation of the first upright terrain that has one.
std::optional<double> height(const Site& site, std::span<const dem::Window> windows, double x,
                             double y) {
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const auto& body = site.ground().bodies[i];
    if (body.inverted || windows[i].empty() || !windows[i].valid(x, y)) continue;
    if (!body.domain.empty() && tree::edge_distance(body.domain, x, y).d < 0) continue;
    return windows[i].height(x, y) + body.offset;
  }
  return std::nullopt;
}

constexpr double square_spacings = 64;  // places in a square of that side share their windows

/// On the input terrain.
Footing on_terrain(const Site& site, std::span<const dem::Window> windows, const Vec3& at) {
  Footing made{at, {0, 0, 1}, 0};
  const auto z = height(site, windows, at.x, at.y);
  if (!z) return made;
  made.found = true;
  made.at.z = *z;
  const double step = site.pixel() / 2;
  const auto along = [&](double dx, double dy) {
    const auto before = height(site, windows, at.x - dx, at.y - dy),
               after = height(site, windows, at.x + dx, at.y + dy);
    const double run = (before ? step : 0) + (after ? step : 0);
    return run > 0 ? (after.value_or(*z) - before.value_or(*z)) / run : 0;
  };
  const double sx = along(step, 0), sy = along(0, step);
  made.slope = std::sqrt(sx * sx + sy * sy);
  made.normal = normalized(Vec3{-sx, -sy, 1});
  return made;
}

/// A place on its way up or down to the surface.
struct Moving {
  std::size_t foot;
  double step;         // the farthest that it moves next [m]
  bool inside = true;  // when it was last looked at
};

/// Where to go from a place whose field is `value`: to the surface as its slope has it, but no
/// farther than half as far each time that the surface was passed.
double next_move(const Site::Value& value, bool first, Moving& moving) {
  const double off = static_cast<double>(value.field) - 0.5, steep = -value.gradient.z;
  const bool inside = off > 0;
  if (!first && inside != moving.inside) moving.step /= 2;
  moving.inside = inside;
  if (steep * moving.step > std::abs(off)) return off / steep;
  return inside ? moving.step : -moving.step;
}

/// Moves what a step of the scene reaches up or down to the surface.
void settle(const Site& site, std::vector<Footing>& feet) {
  constexpr int most_moves = 40;
  constexpr double near = 0.01;  // of F from 1/2
  std::vector<Box> reaches;
  for (const auto& step : site.ground().steps) {
    reaches.push_back(tree::support(step.tree).influence);
  }
  std::vector<Moving> left;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const bool reached =
        std::ranges::any_of(reaches, [&](const Box& box) { return box.contains(feet[i].at); });
    if (feet[i].found && reached) left.push_back({i, 2 * site.spacing()});
  }
  for (int move = 0; move <= most_moves && !left.empty(); ++move) {
    std::vector<Vec3> at;
    for (const auto& moving : left) at.push_back(feet[moving.foot].at);
    const auto values = site.values(at);
    std::vector<Moving> still;
    for (std::size_t n = 0; n < left.size(); ++n) {
      auto& foot = feet[left[n].foot];
      const auto& value = values[n];
      if (std::abs(static_cast<double>(value.field) - 0.5) < near && value.gradient.z < 0) {
        foot.normal = normalized(-value.gradient);
        foot.slope = std::sqrt(std::max(0.0, 1 - foot.normal.z * foot.normal.z)) / foot.normal.z;
        continue;
      }
      foot.at.z += next_move(value, move == 0, left[n]);
      still.push_back(left[n]);
    }
    left = std::move(still);
  }
  for (const auto& moving : left) feet[moving.foot].found = false;
}

}  // namespace

double within_range(double v, double low, double high, double falloff) {
  return trapezoid(v, low - falloff, low, high, high + falloff);
}

HabitatMap::HabitatMap(const Site& site, const Habitat& habitat, const Box& box)
    : habitat_(habitat) {
  const bool drains = !habitat.area.everywhere();
  const double cell = habitat.cell.value_or(site.pixel());
  const Box all = drains ? site.extent() : box.grown(2 * cell);
  ground_ = site.elevations(all, cell, drains ? hydrology::bytes_per_cell + 8 : 16);
  slope_ = hydrology::slope(ground_.grid);
  if (!drains) return;
  auto filled = ground_.grid;
  hydrology::fill(filled);
  const auto to = hydrology::receivers(filled, hydrology::Routing::freeman);
  area_ = hydrology::accumulate(filled, to).area;
}

double HabitatMap::suitability(double x, double y) const {
  const auto cell = ground_.cell(x, y);
  if (!cell || !ground_.grid.valid(*cell)) return 0;
  const auto& altitude = habitat_.altitude;
  double fit = within_range(ground_.between(ground_.grid.z, x, y), altitude.low, altitude.high,
                            altitude.falloff);
  if (fit > 0 && !habitat_.slope.everywhere()) {
    fit *= slope_fit(ground_.between(slope_, x, y), habitat_.slope);
  }
  if (fit > 0 && !area_.empty()) {
    const auto& area = habitat_.area;
    fit *= within_range(ground_.between(area_, x, y), area.low, area.high, area.falloff);
  }
  return fit;
}

std::vector<Footing> footings(const Site& site, const std::vector<Vec3>& at) {
  const double side = square_spacings * site.spacing();
  const auto square = [&](std::size_t i) {
    return std::pair(std::floor(at[i].x / side), std::floor(at[i].y / side));
  };
  std::vector<std::size_t> order(at.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, square);
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || square(order[i]) != square(order[i - 1])) starts.push_back(i);
  }
  starts.push_back(order.size());
  std::vector<Footing> feet(at.size());
  site.in_parallel(starts.size() - 1, [&](std::size_t r) {
    const auto [x, y] = square(order[starts[r]]);
    const Box area{{x * side, y * side, 0}, {(x + 1) * side, (y + 1) * side, 0}};
    const auto windows = site.windows(area.grown(2 * site.pixel()));
    for (auto i = starts[r]; i < starts[r + 1]; ++i) {
      feet[order[i]] = on_terrain(site, windows, at[order[i]]);
    }
  });
  if (!site.ground().steps.empty()) settle(site, feet);
  return feet;
}

}  // namespace hoodoo::generator
