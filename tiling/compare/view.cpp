#include "tiling/compare/view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace hoodoo::compare {
namespace {

using Colour = std::array<double, 3>;

constexpr int size = 400;   // [pixels]
constexpr int margin = 10;  // [pixels]
constexpr std::uint8_t paper = 250;
constexpr std::array<Colour, 3> ramp{{{188, 188, 186}, {245, 190, 40}, {190, 15, 25}}};

Colour colour_of(double part) {
  const double at = std::clamp(part, 0.0, 1.0) * (ramp.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), ramp.size() - 2);
  const double t = at - static_cast<double>(low);
  Colour colour;
  for (std::size_t c = 0; c < 3; ++c) colour[c] = ramp[low][c] * (1 - t) + ramp[low + 1][c] * t;
  return colour;
}

class Drawing {
 public:
  Drawing(const Box& frame, double worst) : worst_(worst) {
    // Corners of the frame, seen: the picture holds them all.
    Box seen;
    for (int i = 0; i < 8; ++i) {
      seen.add(turn({i & 1 ? frame.max.x : frame.min.x, i & 2 ? frame.max.y : frame.min.y,
                     i & 4 ? frame.max.z : frame.min.z}));
    }
    const Vec3 extent = seen.max - seen.min;
    scale_ = (size - 2 * margin) / std::max({extent.x, extent.y, 1e-9});
    middle_ = (seen.min + seen.max) * 0.5;
    picture_.size = size;
    picture_.rgb.assign(3 * std::size_t{size} * size, paper);
    depth_.assign(std::size_t{size} * size, Box::infinity);
  }

  scene::Picture draw(const Shaded& surface) {
    for (const auto& triangle : surface.patch.triangles) {
      const auto off = [&](std::uint32_t corner) { return surface.distances[corner] < 0; };
      if (std::ranges::none_of(triangle, off)) fill(surface, triangle);
    }
    return std::move(picture_);
  }

 private:
  /// East, north, up -> right, up, away.
  Vec3 turn(const Vec3& p) const { return {dot(p, right_), dot(p, up_), dot(p, forward_)}; }
  Vec3 place(const Vec3& p) const {
    const Vec3 seen = (turn(p) - middle_) * scale_;
    return {size / 2.0 + seen.x, size / 2.0 - seen.y, seen.z};
  }
  double part(double distance) const { return worst_ > 0 ? std::min(distance / worst_, 1.0) : 1.0; }

  void fill(const Shaded& surface, const lod::Triangle& triangle) {
    std::array<Vec3, 3> at, corner;
    std::array<double, 3> value{};
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] = surface.patch.points[triangle[i]];
      at[i] = place(corner[i]);
      value[i] = part(surface.distances[triangle[i]]);
    }
    const auto side = [](const Vec3& from, const Vec3& to, double x, double y) {
      return (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x);
    };
    const double whole = side(at[0], at[1], at[2].x, at[2].y);
    if (whole == 0) return;
    const Vec3 normal = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
    const double light = 0.5 + 0.5 * std::max(0.0, dot(normal, sun_));
    const auto [x0, x1] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [y0, y1] = std::minmax({at[0].y, at[1].y, at[2].y});
    const auto pixel = [](double v) { return std::clamp(static_cast<int>(v), 0, size - 1); };
    for (int y = pixel(y0); y <= pixel(y1); ++y) {
      for (int x = pixel(x0); x <= pixel(x1); ++x) {
        const double a = side(at[1], at[2], x + 0.5, y + 0.5) / whole;
        const double b = side(at[2], at[0], x + 0.5, y + 0.5) / whole;
        const double c = 1 - a - b;
        if (a < 0 || b < 0 || c < 0) continue;
        put(x, y, a * at[0].z + b * at[1].z + c * at[2].z,
            a * value[0] + b * value[1] + c * value[2], light);
      }
    }
  }

  void put(int x, int y, double depth, double value, double light) {
    const auto at = static_cast<std::size_t>(y) * size + static_cast<std::size_t>(x);
    if (depth >= depth_[at]) return;
    depth_[at] = depth;
    const Colour colour = colour_of(value);
    for (std::size_t c = 0; c < 3; ++c) {
      picture_.rgb[3 * at + c] = static_cast<std::uint8_t>(light * colour[c]);
    }
  }

  const Vec3 forward_ = normalized(Vec3{0.62, 0.74, -0.9});
  const Vec3 right_ = normalized(cross(forward_, Vec3{0, 0, 1}));
  const Vec3 up_ = cross(right_, forward_);
  const Vec3 sun_ = normalized(Vec3{-0.75, -0.35, 0.9});
  double worst_, scale_ = 1;
  Vec3 middle_;
  scene::Picture picture_;
  std::vector<double> depth_;
};

}  // namespace

scene::Picture draw(const Shaded& surface, const Box& frame, double worst) {
  return Drawing(frame, worst).draw(surface);
}

}  // namespace hoodoo::compare
