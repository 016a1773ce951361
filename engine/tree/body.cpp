#include "engine/tree/body.hpp"

#include <array>
#include <cmath>

#include "engine/tree/dual.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/polygon.hpp"
#include "engine/tree/rows.hpp"

namespace hoodoo::tree {
namespace {

/// (1 + s(u)) / 2, exactly 0 and 1 beyond -1 and 1.
template <class T>
T step(const T& u) {
  using S = Scalar<T>;
  const T c = clamped(u, S(-1), S(1));
  return S(0.5) + S(0.5) * (c * (S(1.5) - S(0.5) * (c * c)));
}

Interval step(const Interval& u) { return {step(u.low), step(u.high)}; }

/// F_T over the block.
Interval terrain_bounds(const HeightBody& body, const dem::Window& window, const Block& block) {
  const Interval h = window.bounds(block.box);
  Interval v = h + Interval{body.offset, body.offset} - Interval{block.box.min.z, block.box.max.z};
  const double slack = 1e-6 * (length(block.box.max - block.box.min) + std::abs(v.low) +
                               std::abs(v.high) + body.falloff);
  v = {v.low - slack, v.high + slack};
  if (body.slope_corrected) {
    const double steepest = window.slope(block.box);
    v = hull(v, v * (1 / std::sqrt(1 + steepest * steepest)));
  }
  if (body.inverted) v = v * -1;
  return step(v * (1 / body.falloff));
}

}  // namespace

struct BodyField::Column {
  double elevation;  // h and offset
  float h;           // elevation relative to the block's origin
  float hx, hy;      // its slope
  float scale;       // +-1 / (R sqrt(1 + |grad h|^2))
  Dual<float> edge;  // F_P; 1 where the edge is far
};

BodyField::BodyField(const HeightBody& body, const dem::Window& window, const Block& block)
    : body_(&body), window_(&window), origin_(block.origin), cut_(false) {
  bounds_ = terrain_bounds(body, window, block);
  if (body.domain.empty()) return;
  const Interval d = edge_distance(body.domain, block.box);
  const double slack = 1e-6 * (length(block.box.max - block.box.min) + body.falloff);
  const Interval prism = step(Interval{d.low - slack, d.high + slack} * (1 / body.falloff));
  cut_ = prism.low < 1;
  bounds_ = min(bounds_, prism);
}

BodyField::Column BodyField::column_at(float x, float y, bool with_gradient) const {
  const double px = origin_.x + static_cast<double>(x), py = origin_.y + static_cast<double>(y);
  Column c{0, 0, 0, 0, static_cast<float>(1 / body_->falloff), 1};
  dem::Height at{0, 0, 0};
  if (with_gradient || body_->slope_corrected) {
    at = window_->at(px, py);
  } else {
    at.h = window_->height(px, py);
  }
  c.elevation = at.h + body_->offset;
  c.h = static_cast<float>(c.elevation - origin_.z);
  c.hx = static_cast<float>(at.hx);
  c.hy = static_cast<float>(at.hy);
  if (body_->slope_corrected) {
    const double stretch = std::sqrt(1 + at.hx * at.hx + at.hy * at.hy);
    c.scale = static_cast<float>(1 / (body_->falloff * stretch));
  }
  if (body_->inverted) c.scale = -c.scale;
  if (cut_) {
    const EdgeDistance e = edge_distance(body_->domain, px, py);
    const double r = 1 / body_->falloff;
    c.edge = step(Dual<float>(static_cast<float>(e.d * r), static_cast<float>(e.dx * r),
                              static_cast<float>(e.dy * r), 0));
  }
  return c;
}

/// Whether points share their column with the next so seldom that all may be looked up at once,
/// which needs nothing of a column but its elevation.
bool BodyField::is_scattered(const Points& at) const {
  if (cut_ || body_->slope_corrected) return false;
  std::size_t columns = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    columns += at.x[i] != at.x[i - 1] || at.y[i] != at.y[i - 1] ? 1 : 0;
  }
  return 4 * columns > at.size();
}

struct BodyField::Scattered {
  std::array<double, batch_size> x, y, h, hx, hy;
  Scattered(const BodyField& body, const Points& at) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      x[i] = body.origin_.x + static_cast<double>(at.x[i]);
      y[i] = body.origin_.y + static_cast<double>(at.y[i]);
    }
  }
};

void BodyField::scattered_values(const Points& at, std::span<float> out) const {
  const std::size_t n = at.size();
  Scattered s(*this, at);
  window_->heights_at({s.x.data(), n}, {s.y.data(), n}, {s.h.data(), n});
  const float scale = static_cast<float>((body_->inverted ? -1 : 1) / body_->falloff);
  for (std::size_t i = 0; i < n; ++i) {
    const auto h = static_cast<float>(s.h[i] + body_->offset - origin_.z);
    out[i] = step((h - at.z[i]) * scale);
  }
}

void BodyField::scattered_gradients(const Points& at, std::span<float> out,
                                    const Gradients& g) const {
  const std::size_t n = at.size();
  Scattered s(*this, at);
  window_->at({s.x.data(), n}, {s.y.data(), n},
              {{s.h.data(), n}, {s.hx.data(), n}, {s.hy.data(), n}});
  const float scale = static_cast<float>((body_->inverted ? -1 : 1) / body_->falloff);
  for (std::size_t i = 0; i < n; ++i) {
    const auto h = static_cast<float>(s.h[i] + body_->offset - origin_.z);
    const Dual<float> v(h - at.z[i], static_cast<float>(s.hx[i]), static_cast<float>(s.hy[i]), -1);
    const Dual<float> f = step(v * scale);
    out[i] = f.v;
    g.x[i] = f.x;
    g.y[i] = f.y;
    g.z[i] = f.z;
  }
}

void BodyField::values(const Points& at, std::span<float> out) const {
  if (is_scattered(at)) return scattered_values(at, out);
  const std::size_t n = at.size();
  for (std::size_t begin = 0; begin < n;) {
    const float x = at.x[begin], y = at.y[begin];
    const Column c = column_at(x, y, false);
    std::size_t end = begin + 1;
    while (end < n && at.x[end] == x && at.y[end] == y) ++end;
    const float* z = at.z.data();
    float* o = out.data();
    for (std::size_t i = begin; i < end; ++i) o[i] = step((c.h - z[i]) * c.scale);
    if (cut_) {
      for (std::size_t i = begin; i < end; ++i) o[i] = smaller(o[i], c.edge.v);
    }
    begin = end;
  }
}

std::unique_ptr<Columns::OfBody> BodyField::columns(const Cube& at) const {
  auto known = std::make_unique<Columns::OfBody>();
  known->edge.fill(1);
  known->scale.fill(static_cast<float>((body_->inverted ? -1 : 1) / body_->falloff));
  if (!cut_ && !body_->slope_corrected) {
    std::array<double, Cube::side> x, y;
    for (std::size_t i = 0; i < Cube::side; ++i) {
      x[i] = origin_.x + static_cast<double>(at.x[i]);
      y[i] = origin_.y + static_cast<double>(at.y[i]);
    }
    std::array<double, Columns::count> h;
    window_->grid(std::span(x).first(at.nx), y, {std::span(h).first(at.nx * y.size()), {}, {}});
    for (std::size_t i = 0; i < at.nx; ++i) {
      for (std::size_t j = 0; j < y.size(); ++j) {
        known->h[Cube::side * i + j] = h[at.nx * j + i] + body_->offset;
      }
    }
    return known;
  }
  for (std::size_t i = 0; i < at.nx; ++i) {
    for (std::size_t j = 0; j < at.ny; ++j) {
      const std::size_t n = Cube::side * i + j;
      const Column c = column_at(at.x[i], at.y[j], false);
      known->h[n] = c.elevation;
      known->scale[n] = c.scale;
      known->edge[n] = c.edge.v;
    }
  }
  return known;
}

void BodyField::cube(const Cube& at, std::unique_ptr<Columns::OfBody>& known,
                     CubeValues out) const {
  if (!known) known = columns(at);
  alignas(64) std::array<float, Columns::count> h;
  for (std::size_t n = 0; n < h.size(); ++n) h[n] = static_cast<float>(known->h[n] - origin_.z);
  step_rows(at, h, known->scale, known->edge, out);
}

void BodyField::gradients(const Points& at, std::span<float> out, const Gradients& g) const {
  if (is_scattered(at)) return scattered_gradients(at, out, g);
  const std::size_t n = at.size();
  for (std::size_t begin = 0; begin < n;) {
    const float x = at.x[begin], y = at.y[begin];
    const Column c = column_at(x, y, true);
    std::size_t i = begin;
    for (; i < n && at.x[i] == x && at.y[i] == y; ++i) {
      const Dual<float> v(c.h - at.z[i], c.hx, c.hy, -1);
      Dual<float> f = step(v * c.scale);
      if (cut_) f = smaller(f, c.edge);
      out[i] = f.v;
      g.x[i] = f.x;
      g.y[i] = f.y;
      g.z[i] = f.z;
    }
    begin = i;
  }
}

const dem::Window* BodyField::elevations() const {
  return cut_ || body_->inverted || body_->offset != 0 ? nullptr : window_;
}

}  // namespace hoodoo::tree
