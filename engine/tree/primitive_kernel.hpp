#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/base/noise.hpp"
#include "engine/tree/evaluate.hpp"

namespace hoodoo::tree {

/// Field of a skeletal primitive over a batch. N is its node type.
template <class N>
class PrimitiveKernel final : public Kernel {
 public:
  using Shape = typename N::template Shape<float>;

  PrimitiveKernel(const N& node, const Vec3& origin, Shape shape)
      : shape_(std::move(shape)),
        origin_(origin),
        noise_(node.turbulence.noise()),
        amplitude_(static_cast<float>(node.turbulence.amplitude)),
        energy_(static_cast<float>(node.energy)),
        reach_(static_cast<float>(reach_of(node))),
        per_square_(static_cast<float>(inverse_square(reach_of(node)))),
        inset_(static_cast<float>(half_falloff * reach_of(node))) {}

  void values(const Points& at, std::span<float> out) const override {
    if (amplitude_ > 0) return rough_values(at, out);
    const std::size_t n = at.size();
    const float *x = at.x.data(), *y = at.y.data(), *z = at.z.data();
    float* o = out.data();
    for (std::size_t i = 0; i < n; ++i) o[i] = smooth(x[i], y[i], z[i]);
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    if (amplitude_ > 0) return rough_gradients(at, out, g);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const D f = smooth(D(at.x[i], 1, 0, 0), D(at.y[i], 0, 1, 0), D(at.z[i], 0, 0, 1));
      out[i] = f.v;
      g.x[i] = f.x;
      g.y[i] = f.y;
      g.z[i] = f.z;
    }
  }

  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(N::type));
  }

  /// R [m].
  static double reach_of(const N& node) {
    if constexpr (N::thin) {
      return node.reach();
    } else {
      return node.falloff;
    }
  }

 private:
  using D = Dual<float>;
  using Row = std::array<float, batch_size>;

  template <class T>
  T smooth(const T& x, const T& y, const T& z) const {
    if constexpr (N::thin) {
      return falloff_of_square(shape_.distance_squared(x, y, z), per_square_, energy_);
    } else {
      return from_distance(shape_.project(x, y, z).distance);
    }
  }
  /// Of a volume, d the signed distance.
  template <class T>
  T from_distance(const T& d) const {
    const T r = larger(T(0.0F), d + inset_);
    return falloff_of_square(r * r, per_square_, energy_);
  }
  /// With turbulence t at the projection; d as `Projection` gives it.
  template <class T>
  T rough(const T& d, const T& t) const {
    const T bump = amplitude_ * (2.0F * t - 1.0F);
    if constexpr (N::thin) {
      const T ratio = d / larger(reach_ + bump, T(1e-6F * reach_));
      return falloff_of_square(ratio * ratio, 1.0F, energy_);
    } else {
      return from_distance(d - bump);
    }
  }

  void rough_values(const Points& at, std::span<float> out) const {
    const std::size_t n = at.size();
    Row d, x, y, z, t;
    for (std::size_t i = 0; i < n; ++i) {
      const auto p = shape_.project(at.x[i], at.y[i], at.z[i]);
      d[i] = p.distance;
      x[i] = p.x;
      y[i] = p.y;
      z[i] = p.z;
    }
    turbulence(noise_, origin_, {x.data(), n}, {y.data(), n}, {z.data(), n}, {t.data(), n});
    for (std::size_t i = 0; i < n; ++i) out[i] = rough(d[i], t[i]);
  }

  void rough_gradients(const Points& at, std::span<float> out, const Gradients& g) const {
    const std::size_t n = at.size();
    std::array<Projection<D>, batch_size> p;
    Row x, y, z, t, tx, ty, tz;
    for (std::size_t i = 0; i < n; ++i) {
      p[i] = shape_.project(D(at.x[i], 1, 0, 0), D(at.y[i], 0, 1, 0), D(at.z[i], 0, 0, 1));
      x[i] = p[i].x.v;
      y[i] = p[i].y.v;
      z[i] = p[i].z.v;
    }
    turbulence_gradient(noise_, origin_, {x.data(), n}, {y.data(), n}, {z.data(), n}, {t.data(), n},
                        {tx.data(), n}, {ty.data(), n}, {tz.data(), n});
    for (std::size_t i = 0; i < n; ++i) {
      // The chain rule: t depends on p through its projection.
      const Projection<D>& q = p[i];
      const D noise(t[i], tx[i] * q.x.x + ty[i] * q.y.x + tz[i] * q.z.x,
                    tx[i] * q.x.y + ty[i] * q.y.y + tz[i] * q.z.y,
                    tx[i] * q.x.z + ty[i] * q.y.z + tz[i] * q.z.z);
      const D f = rough(q.distance, noise);
      out[i] = f.v;
      g.x[i] = f.x;
      g.y[i] = f.y;
      g.z[i] = f.z;
    }
  }

  Shape shape_;
  Vec3 origin_;
  Turbulence noise_;
  float amplitude_, energy_, reach_, per_square_, inset_;
};

/// How far single precision may have moved a primitive [m].
template <class N>
double slack_of(const N& node, const Block& block, const Support& support) {
  if constexpr (requires { node.slack(block); }) {
    return node.slack(block);
  } else {
    return rounding(support.influence, block);
  }
}

/// How far roughness moves the boundary [m] where the points of a box see it.
template <class N>
Interval bump_bounds(const N& node, const Box& box) {
  const double a = node.turbulence.amplitude;
  const Turbulence noise = node.turbulence.noise();
  const Vec3 centre = (box.min + box.max) * 0.5, half = (box.max - box.min) * 0.5;
  // Seen from afar the boundary moves as fast as the points, and nothing is known of a large box.
  if (a == 0 || turbulence_slope(noise) * length(half) > 1) return {-a, a};
  Uncertain::was_undecided();
  const auto p = node.template shape<double>(centre).project(
      Uncertain(-half.x, half.x), Uncertain(-half.y, half.y), Uncertain(-half.z, half.z));
  if (Uncertain::was_undecided()) return {-a, a};
  const Vec3 place = centre + Vec3{p.x.middle(), p.y.middle(), p.z.middle()};
  const double around = length(Vec3{p.x.half(), p.y.half(), p.z.half()});
  return (turbulence_bounds(noise, place, around) * 2 - Interval{1, 1}) * a;
}

/// Bounds of a primitive's field in a block, from its distance at the block's centre: a distance
/// changes by no more than one metre per metre.
template <class N>
Interval primitive_bounds(const N& node, const Block& block, const Support& support) {
  const Vec3 centre = (block.box.min + block.box.max) * 0.5;
  const auto shape = node.template shape<double>(centre);
  double d;
  if constexpr (N::thin) {
    d = std::sqrt(shape.distance_squared(0.0, 0.0, 0.0));
  } else {
    d = shape.project(0.0, 0.0, 0.0).distance;
  }
  const double slack = slack_of(node, block, support);
  const double half = length(block.box.max - block.box.min) / 2 + slack;
  const double reach = PrimitiveKernel<N>::reach_of(node);
  const Interval bump = bump_bounds(node, block.box.grown(2 * slack));
  const auto g = [](double u) {
    const double q = std::max(0.0, 1 - u * u);
    return q * q * q;
  };
  double near, far;  // in units of the reach
  if constexpr (N::thin) {
    near = std::max(0.0, d - half) / (reach + bump.high);
    far = (d + half) / (reach + bump.low);
  } else {
    near = std::max(0.0, d - half - bump.high + half_falloff * reach) / reach;
    far = std::max(0.0, d + half - bump.low + half_falloff * reach) / reach;
  }
  if (near >= 1) return {0, 0};
  const Interval field = outward(Interval{g(far), g(near)} * node.energy);
  return {std::max(field.low, support.range.low), std::min(field.high, support.range.high)};
}

template <class N>
Compiled compile_primitive(const N& node, const Block& block) {
  const Support support = node.support({});
  if (!support.influence.grown(rounding(support.influence, block)).overlaps(block.box)) return {};
  const Interval bounds = primitive_bounds(node, block, support);
  if (bounds == Interval{0, 0}) return {};
  auto shape = node.template shape<float>(block.origin);
  if constexpr (requires { node.keep_near(shape, block); }) {
    if (!node.keep_near(shape, block)) return {};
  }
  return {std::make_unique<PrimitiveKernel<N>>(node, block.origin, std::move(shape)), bounds};
}

}  // namespace hoodoo::tree
