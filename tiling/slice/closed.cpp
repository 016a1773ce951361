#include "tiling/slice/closed.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hoodoo::slice {
namespace {

constexpr float outside = 0.498F;  // W at lattice points that are not inside the world

/// A value with its gradient [1/m].
struct Bound {
  float v, x, y, z;
};

class ClosedField final : public tree::Field {
 public:
  ClosedField(std::unique_ptr<const tree::Field> field, const Closure& closure)
      : field_(std::move(field)),
        inside_(closure.inside),
        per_cell_(1 / static_cast<float>(closure.spacing)),
        floor_(static_cast<float>(closure.floor)) {}

  void values(const tree::Points& at, std::span<float> out) const override {
    field_->values(at, out);
    for (std::size_t n = 0; n < at.size(); ++n) {
      out[n] = std::min(out[n], bound(at.x[n], at.y[n], at.z[n]).v);
    }
  }

  std::size_t grid(const tree::Grid& at, std::span<float> out,
                   tree::Columns* columns) const override {
    field_->grid(at, out, columns);
    std::size_t n = 0;
    for (const float x : at.x) {
      for (const float y : at.y) {
        for (const float z : at.z) {
          out[n] = std::min(out[n], bound(x, y, z).v);
          ++n;
        }
      }
    }
    return n;  // walls and floor are asked everywhere
  }

  void gradients(const tree::Points& at, std::span<float> out,
                 const tree::Gradients& g) const override {
    field_->gradients(at, out, g);
    for (std::size_t n = 0; n < at.size(); ++n) {
      const Bound b = bound(at.x[n], at.y[n], at.z[n]);
      if (out[n] <= b.v) continue;
      out[n] = b.v;
      g.x[n] = b.x;
      g.y[n] = b.y;
      g.z[n] = b.z;
    }
  }

  void materials(const tree::Points& at, std::span<int> out) const override {
    field_->materials(at, out);
  }
  void resistances(const tree::Points& at, std::span<float> out) const override {
    field_->resistances(at, out);
  }
  Interval bounds() const override { return {0, field_->bounds().high}; }
  std::optional<int> material() const override { return field_->material(); }
  const dem::Window* height_field() const override { return nullptr; }
  std::vector<std::string> explain() const override { return field_->explain(); }

 private:
  Bound bound(float x, float y, float z) const {
    const Bound wall = wall_at(x * per_cell_, y * per_cell_);
    const float rise = 0.5F + (z - floor_) * (0.5F * per_cell_);
    if (rise >= wall.v) return wall;
    return rise > 0 ? Bound{rise, 0, 0, 0.5F * per_cell_} : Bound{0, 0, 0, 0};
  }

  /// At a place in cells.
  Bound wall_at(float u, float v) const {
    const float i = std::clamp(std::floor(u), 0.0F, 15.0F);
    const float j = std::clamp(std::floor(v), 0.0F, 15.0F);
    const auto corner = [&](std::size_t di, std::size_t dj) {
      return inside_[static_cast<std::size_t>(j) + dj][static_cast<std::size_t>(i) + di] ? 1.0F
                                                                                         : outside;
    };
    const float a = corner(0, 0), b = corner(1, 0), c = corner(0, 1), d = corner(1, 1);
    const float s = u - i, t = v - j;
    const float low = a + (b - a) * s, high = c + (d - c) * s;
    return {low + (high - low) * t, ((b - a) + ((d - c) - (b - a)) * t) * per_cell_,
            (high - low) * per_cell_, 0};
  }

  std::unique_ptr<const tree::Field> field_;
  std::array<std::array<bool, 17>, 17> inside_;
  float per_cell_, floor_;
};

}  // namespace

bool Closure::is_open() const {
  if (floor > -spacing) return false;
  return std::ranges::all_of(inside, [](const auto& row) {
    return std::ranges::all_of(row, [](bool point) { return point; });
  });
}

std::unique_ptr<const tree::Field> closed(std::unique_ptr<const tree::Field> field,
                                          const Closure& closure) {
  if (closure.is_open()) return field;
  return std::make_unique<ClosedField>(std::move(field), closure);
}

}  // namespace hoodoo::slice
