#include "engine/tree/distance.hpp"

#include <cassert>
#include <limits>
#include <type_traits>
#include <variant>

#include "engine/tree/composite.hpp"
#include "engine/tree/node.hpp"
#include "engine/tree/primitive_kernel.hpp"
#include "engine/tree/space_kernel.hpp"

namespace hoodoo::tree {
namespace {

/// Of a volumetric primitive: d, or d - a (2t - 1) with turbulence t on its boundary.
template <class N>
class DistanceKernel final : public Kernel {
 public:
  DistanceKernel(const N& node, const Vec3& origin)
      : shape_(node.template shape<float>(origin)),
        origin_(origin),
        noise_(node.turbulence.noise()),
        amplitude_(static_cast<float>(node.turbulence.amplitude)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    Rows place;
    for (std::size_t i = 0; i < n; ++i) {
      const auto p = shape_.project(at.x[i], at.y[i], at.z[i]);
      out[i] = p.distance;
      place.x[i] = p.x;
      place.y[i] = p.y;
      place.z[i] = p.z;
    }
    if (amplitude_ == 0) return;
    std::array<float, batch_size> t;
    const Points v = place.points(n);
    turbulence(noise_, origin_, v.x, v.y, v.z, {t.data(), n});
    for (std::size_t i = 0; i < n; ++i) out[i] = rough(out[i], t[i]);
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    std::array<Projection<D>, batch_size> p;
    Rows place;
    for (std::size_t i = 0; i < n; ++i) {
      p[i] = shape_.project(D(at.x[i], 1, 0, 0), D(at.y[i], 0, 1, 0), D(at.z[i], 0, 0, 1));
      place.x[i] = p[i].x.v;
      place.y[i] = p[i].y.v;
      place.z[i] = p[i].z.v;
    }
    Slopes t;
    const Points v = place.points(n);
    const Gradients slope = t.spans(n);
    if (amplitude_ != 0) {
      turbulence_gradient(noise_, origin_, v.x, v.y, v.z, t.values(n), slope.x, slope.y, slope.z);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const auto& q = p[i];
      if (amplitude_ == 0) {
        put(q.distance, i, out, g);
        continue;
      }
      const D noise(t.v[i], t.x[i] * q.x.x + t.y[i] * q.y.x + t.z[i] * q.z.x,
                    t.x[i] * q.x.y + t.y[i] * q.y.y + t.z[i] * q.z.y,
                    t.x[i] * q.x.z + t.y[i] * q.y.z + t.z[i] * q.z.z);
      put(rough(q.distance, noise), i, out, g);
    }
  }

  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, N::type));
  }

 private:
  using D = Dual<float>;
  template <class T>
  T rough(const T& d, const T& t) const {
    return d - amplitude_ * (2.0F * t - 1.0F);
  }
  typename N::template Shape<float> shape_;
  Vec3 origin_;
  Turbulence noise_;
  float amplitude_;
};

/// `start` of the first child, then `meet` with each other.
template <class N>
class OperatorKernel final : public Kernel {
 public:
  OperatorKernel(const N& node, std::vector<std::unique_ptr<const Kernel>> children)
      : node_(node), children_(std::move(children)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> d;
    children_[0]->values(at, out);
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.start(out[i]);
    for (std::size_t c = 1; c < children_.size(); ++c) {
      children_[c]->values(at, {d.data(), n});
      for (std::size_t i = 0; i < n; ++i) out[i] = node_.meet(out[i], d[i]);
    }
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    Slopes d;
    children_[0]->gradients(at, out, g);
    const auto so_far = [&](std::size_t i) { return Dual<float>(out[i], g.x[i], g.y[i], g.z[i]); };
    for (std::size_t i = 0; i < n; ++i) put(node_.start(so_far(i)), i, out, g);
    for (std::size_t c = 1; c < children_.size(); ++c) {
      children_[c]->gradients(at, d.values(n), d.spans(n));
      for (std::size_t i = 0; i < n; ++i) put(node_.meet(so_far(i), d.at(i)), i, out, g);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, N::type));
    for (const auto& child : children_) child->explain(depth + 1, lines);
  }

 private:
  N node_;
  std::vector<std::unique_ptr<const Kernel>> children_;
};

/// `far` is nowhere so near `near` that it has a part in their union: it leaves the same bits out.
/// Distances change by no more than one metre per metre, so bounds tell: |f_A - f_B| > 2 r + k.
bool beaten(const Interval& near, const Interval& far, double width) {
  return far.low > near.high + width;
}

template <class N>
Compiled compile_operator(const N& node, const std::vector<Node>& children, const Block& block) {
  std::vector<std::unique_ptr<const Kernel>> kernels;
  Interval bounds;
  for (const Node& child : children) {
    Compiled one = compile_distance(child, block);
    if constexpr (std::is_same_v<N, DistanceUnion>) {
      if (!kernels.empty() && beaten(bounds, one.bounds, node.width)) continue;
      if (beaten(one.bounds, bounds, node.width)) kernels.clear();
    }
    bounds = kernels.empty() ? node.start(one.bounds) : node.meet(bounds, one.bounds);
    kernels.push_back(std::move(one.kernel));
  }
  return {std::make_unique<OperatorKernel<N>>(node, std::move(kernels)), outward(bounds)};
}

/// From the distance at the block's centre, which changes by no more than one metre per metre.
template <class N>
Compiled compile_volume(const N& node, const Block& block) {
  const Vec3 centre = (block.box.min + block.box.max) * 0.5;
  const double d = node.template shape<double>(centre).project(0.0, 0.0, 0.0).distance;
  const double slack = slack_of(node, block, node.support({}));
  const double away = length(block.box.max - block.box.min) / 2 + slack;
  const Interval distance =
      Interval{d - away, d + away} - bump_bounds(node, block.box.grown(2 * slack));
  return {std::make_unique<DistanceKernel<N>>(node, block.origin), outward(distance)};
}

class FieldKernel final : public Kernel {
 public:
  FieldKernel(const FromDistance& node, std::unique_ptr<const Kernel> distance)
      : node_(node), distance_(std::move(distance)) {}
  void values(const Points& at, std::span<float> out) const override {
    distance_->values(at, out);
    for (float& v : out) v = node_.field(v);
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    distance_->gradients(at, out, g);
    for (std::size_t i = 0; i < at.size(); ++i) {
      put(node_.field(Dual<float>(out[i], g.x[i], g.y[i], g.z[i])), i, out, g);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, FromDistance::type));
    distance_->explain(depth + 1, lines);
  }

 private:
  FromDistance node_;
  std::unique_ptr<const Kernel> distance_;
};

}  // namespace

Compiled compile_distance(const Node& tree, const Block& block) {
  return std::visit(
      [&](const auto& node) -> Compiled {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (VolumePrimitive<N>) {
          return compile_volume(node, block);
        } else if constexpr (N::family == Family::distance) {
          return node.compile_node(tree.children, block);
        } else if constexpr (RigidTransform<N>) {
          return compile_transform(node,
                                   compile_distance(tree.children[0], inner_block(node, block)));
        } else {
          assert(false && "no distance");
          return {};
        }
      },
      tree.value);
}

Support distance_support(const Node& tree) {
  std::vector<Support> children;
  for (const Node& child : tree.children) children.push_back(distance_support(child));
  return std::visit(
      [&](const auto& node) -> Support {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (VolumePrimitive<N>) {
          // The solid, which its field's influence holds and more.
          const Support field = node.support({});
          const double slope = node.turbulence.amplitude > 0 ? Support::no_bound : 1;
          return {field.influence.grown(-node.falloff * (1 - half_falloff)), Interval::everything(),
                  slope};
        } else {
          return node.support(children);
        }
      },
      tree.value);
}

double thickest(const Node& tree) {
  double below = 0;
  for (const Node& child : tree.children) below = std::max(below, thickest(child));
  return std::visit(
      [&](const auto& node) {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (VolumePrimitive<N>) {
          return 2 * node.half_thickness();
        } else if constexpr (requires { node.thickness(below); }) {
          return node.thickness(below);
        } else {
          return below;
        }
      },
      tree.value);
}

Support FromDistance::support(std::span<const Support> children) const {
  const Box& solid = children[0].influence;
  const double slack = solid.empty() ? 0 : 1e-5 * (falloff + length(solid.max - solid.min));
  const double steep = children[0].slope * 0.5 / std::max(falloff, 1e-15);
  return {solid.grown(falloff + slack), {0, 1}, steep};
}

Compiled FromDistance::compile_node(const std::vector<Node>& children, const Block& block) const {
  const Support child = distance_support(children[0]);
  if (!reaches(support({&child, 1}).influence, block.box)) return {};
  Compiled distance = compile_distance(children[0], block);
  const Interval& d = distance.bounds;
  const Interval bounds{field(d.high), field(d.low)};
  if (bounds.high <= 0) return {};
  return {std::make_unique<FieldKernel>(*this, std::move(distance.kernel)), outward(bounds)};
}

Node FromDistance::prune_node(const std::vector<Node>& children, const Box& reach,
                              double thinnest) const {
  const Support child = distance_support(children[0]);
  const bool keep =
      reaches(support({&child, 1}).influence, reach) && thickest(children[0]) >= thinnest;
  return keep ? Node{*this, children} : nothing();
}

Compiled Offset::compile_node(const std::vector<Node>& children, const Block& block) const {
  return compile_operator(*this, children, block);
}
Compiled Shell::compile_node(const std::vector<Node>& children, const Block& block) const {
  return compile_operator(*this, children, block);
}
Compiled DistanceUnion::compile_node(const std::vector<Node>& children, const Block& block) const {
  return compile_operator(*this, children, block);
}

// A part of a distance matters to all of it: only the whole is left out.
Node Offset::prune_node(const std::vector<Node>& children, const Box&, double) const {
  return {*this, children};
}
Node Shell::prune_node(const std::vector<Node>& children, const Box&, double) const {
  return {*this, children};
}
Node DistanceUnion::prune_node(const std::vector<Node>& children, const Box&, double) const {
  return {*this, children};
}

}  // namespace hoodoo::tree
