#pragma once
#include <array>
#include <memory>
#include <vector>

#include "engine/tree/combine.hpp"
#include "engine/tree/dual.hpp"
#include "engine/tree/evaluate.hpp"

namespace hoodoo::tree {

/// Joins its children's values point by point. A child without kernel is 0.
template <class N>
class CombineKernel final : public Kernel {
 public:
  CombineKernel(const N& node, std::vector<std::unique_ptr<const Kernel>> children)
      : node_(node), children_(std::move(children)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> child;
    put_values(children_[0].get(), at, out);
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.first(out[i]);
    for (std::size_t c = 1; c < children_.size(); ++c) {
      put_values(children_[c].get(), at, {child.data(), n});
      for (std::size_t i = 0; i < n; ++i) out[i] = node_.join(out[i], child[i]);
    }
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.last(out[i]);
  }

  void cube(const Cube& at, CubeValues out, AskedRows& asked) const override {
    if constexpr (requires { node_.of_zero(); }) {
      if (node_.of_zero() != 0) asked.fill(1);
    }
    const std::size_t n = batch_size * at.nx;
    std::array<float, Cube::size> child;
    put_cube(children_[0].get(), at, out, asked);
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.first(out[i]);
    for (std::size_t c = 1; c < children_.size(); ++c) {
      put_cube(children_[c].get(), at, child, asked);
      for (std::size_t i = 0; i < n; ++i) out[i] = node_.join(out[i], child[i]);
    }
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.last(out[i]);
  }

  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> v, x, y, z;
    const Gradients child{{x.data(), n}, {y.data(), n}, {z.data(), n}};
    put_gradients(children_[0].get(), at, out, g);
    const auto update = [&](auto change) {
      for (std::size_t i = 0; i < n; ++i) {
        const D f = change(D(out[i], g.x[i], g.y[i], g.z[i]), i);
        out[i] = f.v;
        g.x[i] = f.x;
        g.y[i] = f.y;
        g.z[i] = f.z;
      }
    };
    update([&](const D& f, std::size_t) { return node_.first(f); });
    for (std::size_t c = 1; c < children_.size(); ++c) {
      put_gradients(children_[c].get(), at, {v.data(), n}, child);
      update([&](const D& f, std::size_t i) { return node_.join(f, D(v[i], x[i], y[i], z[i])); });
    }
    update([&](const D& f, std::size_t) { return node_.last(f); });
  }

  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(N::type));
    for (const auto& child : children_) {
      if (child) child->explain(depth + 1, lines);
    }
  }

 private:
  using D = Dual<float>;

  static void put_values(const Kernel* child, const Points& at, std::span<float> out) {
    if (child != nullptr) return child->values(at, out);
    std::fill(out.begin(), out.end(), 0.0F);
  }
  static void put_cube(const Kernel* child, const Cube& at, CubeValues out, AskedRows& asked) {
    if (child != nullptr) return child->cube(at, out, asked);
    std::fill(out.begin(), out.end(), 0.0F);
  }
  static void put_gradients(const Kernel* child, const Points& at, std::span<float> out,
                            const Gradients& g) {
    if (child != nullptr) return child->gradients(at, out, g);
    for (const auto& part : {out, g.x, g.y, g.z}) std::fill(part.begin(), part.end(), 0.0F);
  }

  N node_;
  std::vector<std::unique_ptr<const Kernel>> children_;
};

/// The term of the child that decides the minimum or maximum at the least.
template <class N>
double bar(const N& node, const std::vector<Compiled>& children) {
  double best = node.term(0, children[0].bounds).low;
  if constexpr (N::pick == Pick::smallest) best = node.term(0, children[0].bounds).high;
  for (std::size_t i = 1; i < children.size(); ++i) {
    const Interval term = node.term(i, children[i].bounds);
    best = N::pick == Pick::largest ? std::max(best, term.low) : std::min(best, term.high);
  }
  return best;
}

/// Which children can matter in the block. One that is 0 throughout changes nothing in a sum, nor
/// after another such one. The first stays where it has a part of its own.
template <class N>
std::vector<bool> wanted(const N& node, const std::vector<Compiled>& children) {
  std::vector<bool> keep(children.size(), true);
  if constexpr (N::pick != Pick::none) {
    const double best = bar(node, children);
    for (std::size_t i = 0; i < children.size(); ++i) {
      const Interval term = node.term(i, children[i].bounds);
      const bool beaten = N::pick == Pick::largest ? term.high < best : term.low > best;
      keep[i] = !beaten || (i == 0 && N::first_is_special);
    }
  }
  bool zero = false;
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (!keep[i] || children[i].kernel) continue;
    if (i > 0 && (zero || N::adds)) keep[i] = false;
    zero = true;
  }
  return keep;
}

template <class N>
Compiled compile_combiner(const N& node, std::vector<Compiled> children) {
  bool any = false;
  for (const Compiled& child : children) any = any || child.kernel;
  if constexpr (requires { node.of_zero(); }) any = any || node.of_zero() != 0;
  if (!any) return {};
  Interval bounds = node.first(children[0].bounds);
  for (std::size_t i = 1; i < children.size(); ++i) bounds = node.join(bounds, children[i].bounds);
  bounds = node.last(bounds);
  // Minimum and maximum do not round.
  if constexpr (N::pick == Pick::none) bounds = outward(bounds);
  if (bounds == Interval{0, 0}) return {};
  const std::vector<bool> keep = wanted(node, children);
  std::vector<std::unique_ptr<const Kernel>> kept;
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (keep[i]) kept.push_back(std::move(children[i].kernel));
  }
  return {std::make_unique<CombineKernel<N>>(node, std::move(kept)), bounds};
}

}  // namespace hoodoo::tree
