#pragma once
#include <array>
#include <memory>

#include "engine/tree/dual.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/transform.hpp"

namespace hoodoo::tree {

/// Three rows of a batch.
struct Rows {
  std::array<float, batch_size> x, y, z;
  Points points(std::size_t n) const { return {{x.data(), n}, {y.data(), n}, {z.data(), n}}; }
  Gradients spans(std::size_t n) { return {{x.data(), n}, {y.data(), n}, {z.data(), n}}; }
};

/// Evaluates a child at a linear map of the points; the offset is in the child's origin.
template <class N>
class TransformKernel final : public Kernel {
 public:
  TransformKernel(const N& node, std::unique_ptr<const Kernel> child) : child_(std::move(child)) {
    const Matrix m = node.inward();
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m_[r][c] = static_cast<float>(m[r][c]);
    }
  }

  void values(const Points& at, std::span<float> out) const override {
    Rows moved;
    move(at, moved);
    child_->values(moved.points(at.size()), out);
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    Rows moved;
    move(at, moved);
    child_->gradients(moved.points(at.size()), out, g);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const float x = g.x[i], y = g.y[i], z = g.z[i];
      g.x[i] = m_[0][0] * x + m_[1][0] * y + m_[2][0] * z;
      g.y[i] = m_[0][1] * x + m_[1][1] * y + m_[2][1] * z;
      g.z[i] = m_[0][2] * x + m_[1][2] * y + m_[2][2] * z;
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(N::type));
    child_->explain(depth + 1, lines);
  }

 private:
  void move(const Points& at, Rows& to) const {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const float x = at.x[i], y = at.y[i], z = at.z[i];
      to.x[i] = m_[0][0] * x + m_[0][1] * y + m_[0][2] * z;
      to.y[i] = m_[1][0] * x + m_[1][1] * y + m_[1][2] * z;
      to.z[i] = m_[2][0] * x + m_[2][1] * y + m_[2][2] * z;
    }
  }

  std::array<std::array<float, 3>, 3> m_;
  std::unique_ptr<const Kernel> child_;
};

/// The block as the child of a transform sees it.
template <class N>
Block inner_block(const N& node, const Block& block) {
  const auto to = [&](const Vec3& p) { return node.to_child(p); };
  return {node.to_child(block.origin), mapped(block.box, to)};
}

template <class N>
Compiled compile_transform(const N& node, Compiled child) {
  if (!child.kernel || node.inward() == unit_matrix) return child;
  return {std::make_unique<TransformKernel<N>>(node, std::move(child.kernel)), child.bounds};
}

/// Evaluates a child at points moved by the node's displacement, times a control field.
template <class N>
class DisplacementKernel final : public Kernel {
 public:
  DisplacementKernel(const N& node, const Vec3& origin, std::unique_ptr<const Kernel> child,
                     std::unique_ptr<const Kernel> control)
      : node_(node), origin_(origin), child_(std::move(child)), control_(std::move(control)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> weight, delta;
    if (control_) {
      control_->values(at, {weight.data(), n});
      for (std::size_t i = 0; i < n; ++i) weight[i] = clamped(weight[i], 0.0F, 1.0F);
    } else {
      weight.fill(1);
    }
    Rows moved;
    const auto along = [&](int axis, std::span<const float> from, float* to) {
      node_.displacement(axis, origin_, at, {delta.data(), n});
      for (std::size_t i = 0; i < n; ++i) to[i] = from[i] + delta[i] * weight[i];
    };
    along(0, at.x, moved.x.data());
    along(1, at.y, moved.y.data());
    along(2, at.z, moved.z.data());
    child_->values(moved.points(n), out);
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> weight, delta;
    Rows weight_slope, delta_slope, moved, child;
    if (control_) {
      control_->gradients(at, {weight.data(), n}, weight_slope.spans(n));
    } else {
      weight.fill(1);
      for (auto* row : {&weight_slope.x, &weight_slope.y, &weight_slope.z}) row->fill(0);
    }
    // Jacobian of the moved point: row `axis` is the unit vector + gradient of delta * weight.
    std::array<Rows, 3> jacobian;
    const auto along = [&](int axis, std::span<const float> from, float* to) {
      node_.displacement_gradient(axis, origin_, at, {delta.data(), n}, delta_slope.spans(n));
      Rows& row = jacobian[static_cast<std::size_t>(axis)];
      for (std::size_t i = 0; i < n; ++i) {
        const D w = clamped(D(weight[i], weight_slope.x[i], weight_slope.y[i], weight_slope.z[i]),
                            0.0F, 1.0F);
        const D d(delta[i], delta_slope.x[i], delta_slope.y[i], delta_slope.z[i]);
        const D p(from[i], axis == 0 ? 1.0F : 0.0F, axis == 1 ? 1.0F : 0.0F,
                  axis == 2 ? 1.0F : 0.0F);
        const D q = p + d * w;
        to[i] = q.v;
        row.x[i] = q.x;
        row.y[i] = q.y;
        row.z[i] = q.z;
      }
    };
    along(0, at.x, moved.x.data());
    along(1, at.y, moved.y.data());
    along(2, at.z, moved.z.data());
    child_->gradients(moved.points(n), out, child.spans(n));
    const auto& [jx, jy, jz] = jacobian;
    for (std::size_t i = 0; i < n; ++i) {
      g.x[i] = child.x[i] * jx.x[i] + child.y[i] * jy.x[i] + child.z[i] * jz.x[i];
      g.y[i] = child.x[i] * jx.y[i] + child.y[i] * jy.y[i] + child.z[i] * jz.y[i];
      g.z[i] = child.x[i] * jx.z[i] + child.y[i] * jy.z[i] + child.z[i] * jz.z[i];
    }
  }

  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(N::type));
    child_->explain(depth + 1, lines);
    if (control_) control_->explain(depth + 1, lines);
  }

 private:
  using D = Dual<float>;
  N node_;
  Vec3 origin_;
  std::unique_ptr<const Kernel> child_, control_;
};

/// Where the points of a box are moved to, with a control field in `weight`.
template <class N>
Box displaced(const N& node, const Box& box, const Interval& weight) {
  const double around = length(box.max - box.min) / 2;
  Box to;
  for (int axis = 0; axis < 3; ++axis) {
    const Interval by = node.displacement_bounds(axis, (box.min + box.max) * 0.5, around) * weight;
    to.min[axis] = box.min[axis] + by.low;
    to.max[axis] = box.max[axis] + by.high;
  }
  return to;
}

/// Where the control field is 0 throughout, the child stands as it is.
template <class N>
Compiled compile_displacement(const N& node, const std::vector<Node>& children,
                              const Block& block) {
  Compiled control;
  if (children.size() > 1) {
    control = compile(children[1], block);
    if (!control.kernel || control.bounds.high <= 0) return compile(children[0], block);
  }
  const Interval weight = control.kernel ? clamp(control.bounds, 0, 1) : Interval{1, 1};
  const Box source = displaced(node, block.box, weight);
  Compiled child = compile(children[0], {block.origin, source.grown(rounding(source, block))});
  if (!child.kernel) return {};
  return {std::make_unique<DisplacementKernel<N>>(node, block.origin, std::move(child.kernel),
                                                  std::move(control.kernel)),
          child.bounds};
}

}  // namespace hoodoo::tree
