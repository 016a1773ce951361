#include "engine/tree/deform.hpp"

#include <cmath>

#include "engine/base/math.hpp"
#include "engine/tree/composite.hpp"
#include "engine/tree/nodes/taper.hpp"
#include "engine/tree/nodes/twist.hpp"
#include "engine/tree/space_kernel.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {
namespace {

bool infinite(const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isinf(box.min[axis]) || std::isinf(box.max[axis])) return true;
  }
  return false;
}

/// Evaluates a child at points that the node's map moves, as far as a control field says.
template <class N>
class DeformKernel final : public Kernel {
 public:
  DeformKernel(const N& node, const Vec3& origin, std::unique_ptr<const Kernel> child,
               std::unique_ptr<const Kernel> control)
      : map_(node.template map<float>(origin)),
        child_(std::move(child)),
        control_(std::move(control)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> weight;
    if (control_) control_->values(at, {weight.data(), n});
    Rows moved;
    for (std::size_t i = 0; i < n; ++i) {
      const float w = control_ ? clamped(weight[i], 0.0F, 1.0F) : 1.0F;
      float x = at.x[i], y = at.y[i], z = at.z[i];
      map_(x, y, z, w);
      moved.x[i] = x;
      moved.y[i] = y;
      moved.z[i] = z;
    }
    child_->values(moved.points(n), out);
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    Slopes weight, child;
    if (control_) control_->gradients(at, weight.values(n), weight.spans(n));
    Rows moved;
    std::array<std::array<D, 3>, batch_size> image;
    for (std::size_t i = 0; i < n; ++i) {
      const D w = control_ ? clamped(weight.at(i), 0.0F, 1.0F) : D(1.0F);
      auto& [x, y, z] = image[i];
      x = D(at.x[i], 1, 0, 0);
      y = D(at.y[i], 0, 1, 0);
      z = D(at.z[i], 0, 0, 1);
      map_(x, y, z, w);
      moved.x[i] = x.v;
      moved.y[i] = y.v;
      moved.z[i] = z.v;
    }
    child_->gradients(moved.points(n), out, child.spans(n));
    for (std::size_t i = 0; i < n; ++i) {
      const auto& [x, y, z] = image[i];
      g.x[i] = child.x[i] * x.x + child.y[i] * y.x + child.z[i] * z.x;
      g.y[i] = child.x[i] * x.y + child.y[i] * y.y + child.z[i] * z.y;
      g.z[i] = child.x[i] * x.z + child.y[i] * y.z + child.z[i] * z.z;
    }
  }

  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, N::type));
    child_->explain(depth + 1, lines);
    if (control_) control_->explain(depth + 1, lines);
  }

 private:
  using D = Dual<float>;
  typename N::template Map<float> map_;
  std::unique_ptr<const Kernel> child_, control_;
};

/// Contains where the points of a box are moved to: about its centre's image, with a control field
/// in `weight`.
template <class N>
Box image(const N& node, const Box& box, const Interval& weight) {
  const Vec3 center = (box.min + box.max) * 0.5;
  double x = 0, y = 0, z = 0;
  node.template map<double>(center)(x, y, z, (weight.low + weight.high) / 2);
  const Bend bend = node.bend();
  const double away = farthest_from(node, box);
  const double off = length(box.max - box.min) / 2 * (bend.stretch + away * bend.per_metre) +
                     away * bend.per_control * weight.width() / 2;
  const Vec3 moved = center + Vec3{x, y, z};
  return Box{moved, moved}.grown(off * (1 + 1e-9) + 1e-9 * (1 + away));
}

/// Where the control field is 0 throughout, the child stands as it is.
template <class N>
Compiled compile_deformation(const N& node, const std::vector<Node>& children, const Block& block) {
  Compiled control;
  if (children.size() > 1) {
    control = compile(children[1], block);
    if (!control.kernel || control.bounds.high <= 0) return compile(children[0], block);
  }
  const Interval weight = control.kernel ? clamp(control.bounds, 0, 1) : Interval{1, 1};
  Box source = intersection(node.source(block.box), image(node, block.box, weight));
  source = source.grown(rounding(source, block));
  Compiled child = compile(children[0], {block.origin, source});
  if (!child.kernel) return {};
  return {std::make_unique<DeformKernel<N>>(node, block.origin, std::move(child.kernel),
                                            std::move(control.kernel)),
          child.bounds};
}

template <class N>
Node prune_deformation(const N& node, const std::vector<Node>& children, const Box& reach,
                       double thinnest) {
  // The source of an infinite reach is everywhere: the influence says more.
  if (!reaches(node.support(supports(children)).influence, reach)) return nothing();
  Node control = nothing();
  if (children.size() > 1) {
    control = prune(children[1], reach, 0);
    if (is_nothing(control)) return prune(children[0], reach, thinnest);
  }
  const Box source = node.source(reach);
  Node child = prune(children[0], source.grown(1e-5 * length(source.max - source.min)),
                     thinnest / node.shrink());
  if (is_nothing(child)) return child;
  Node pruned{node, {std::move(child)}};
  if (children.size() > 1) pruned.children.push_back(std::move(control));
  return pruned;
}

}  // namespace

Box stretched(const Spine& spine, const Box& box, double factor) {
  if (box.empty()) return box;
  if (infinite(box)) return Box::everywhere();
  const Vec3 axis = normalized(spine.axis);
  return mapped(box, [&](const Vec3& p) {
    const Vec3 d = p - spine.center.value, along = axis * dot(d, axis);
    return spine.center.value + along + (d - along) * factor;
  });
}

double farthest_from(const Spine& spine, const Box& box) {
  if (box.empty()) return 0;
  if (infinite(box)) return Box::infinity;
  const Vec3 axis = normalized(spine.axis);
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 d =
        Vec3{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
             (corner & 4) != 0 ? box.max.z : box.min.z} -
        spine.center.value;
    most = std::max(most, length(d - axis * dot(d, axis)));
  }
  return most;
}

Box revolved(const Spine& spine, const Box& box) {
  if (box.empty()) return box;
  if (infinite(box)) return Box::everywhere();
  const Vec3 axis = normalized(spine.axis);
  const double r = farthest_from(spine, box) * (1 + 1e-9) + 1e-9;
  const auto across = [&](double a) { return r * std::sqrt(std::max(0.0, 1 - a * a)); };
  const Vec3 disk{across(axis.x), across(axis.y), across(axis.z)};
  const Box on_axis = stretched(spine, box, 0);
  Box all{on_axis.min - disk, on_axis.max + disk};
  all.add(box);
  return all;
}

double steepened(double slope, double stretch, double away, double bend) {
  if (slope == 0) return 0;
  return slope * (stretch + (bend > 0 ? away * bend : 0));
}

Support Taper::support(std::span<const Support> children) const {
  Support all = children[0];
  all.influence.add(stretched(*this, children[0].influence, factor));
  const double control = children.size() > 1 ? children[1].slope : 0;
  const Bend b = bend();
  all.slope = steepened(all.slope, b.stretch, farthest_from(*this, all.influence),
                        b.per_metre + b.per_control * control);
  return all;
}

Bend Taper::bend() const {
  const Interval k = inverse();
  // d(1/s)/dh = (factor - 1) / (length s^2).
  return {k.high, std::abs(factor - 1) / length * k.high * k.high, k.width()};
}

Box Taper::source(const Box& box) const {
  Box all = box;
  all.add(stretched(*this, box, 1 / factor));
  return all;
}

Support Twist::support(std::span<const Support> children) const {
  Support all = children[0];
  all.influence = revolved(*this, children[0].influence);
  const double control = children.size() > 1 ? children[1].slope : 0;
  const Bend b = bend();
  all.slope = steepened(all.slope, b.stretch, farthest_from(*this, children[0].influence),
                        b.per_metre + b.per_control * control);
  return all;
}

Bend Twist::bend() const {
  const double turn = std::abs(angle) * (pi / 180);
  return {1, turn / length, turn};
}

Compiled Taper::compile_node(const std::vector<Node>& children, const Block& block) const {
  return compile_deformation(*this, children, block);
}
Node Taper::prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const {
  return prune_deformation(*this, children, reach, thinnest);
}
Compiled Twist::compile_node(const std::vector<Node>& children, const Block& block) const {
  return compile_deformation(*this, children, block);
}
Node Twist::prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const {
  return prune_deformation(*this, children, reach, thinnest);
}

}  // namespace hoodoo::tree
