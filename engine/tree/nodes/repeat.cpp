#include "engine/tree/nodes/repeat.hpp"

#include "engine/tree/composite.hpp"
#include "engine/tree/space_kernel.hpp"

namespace hoodoo::tree {
namespace {

/// Instances that are left out are 0, which changes neither the union nor the sum.
class RepeatKernel final : public Kernel {
 public:
  RepeatKernel(Repeat::Join join, std::vector<std::unique_ptr<const Kernel>> instances)
      : sum_(join == Repeat::Join::blend), instances_(std::move(instances)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> one;
    std::fill(out.begin(), out.end(), 0.0F);
    for (const auto& instance : instances_) {
      instance->values(at, {one.data(), n});
      for (std::size_t i = 0; i < n; ++i) out[i] = joined(out[i], one[i]);
    }
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    Slopes one;
    put_gradients(nullptr, at, out, g);
    for (const auto& instance : instances_) {
      instance->gradients(at, one.values(n), one.spans(n));
      for (std::size_t i = 0; i < n; ++i) {
        put(joined(Dual<float>(out[i], g.x[i], g.y[i], g.z[i]), one.at(i)), i, out, g);
      }
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, Repeat::type));
    for (const auto& instance : instances_) instance->explain(depth + 1, lines);
  }

 private:
  template <class T>
  T joined(const T& all, const T& one) const {
    return sum_ ? all + one : larger(all, one);
  }
  bool sum_;
  std::vector<std::unique_ptr<const Kernel>> instances_;
};

Box placed(const Placement& placement, const Box& box) {
  return mapped(box, [&](const Vec3& p) { return placement.from_child(p); });
}
Box seen_from(const Placement& placement, const Box& box) {
  return mapped(box, [&](const Vec3& p) { return placement.to_child(p); });
}

}  // namespace

Support Repeat::support(std::span<const Support> children) const {
  const Support& child = children[0];
  Support all{Box(), {0, 0}, 0};
  for (const Placement& p : placements) {
    all.influence.add(placed(p, child.influence));
    const double slope = child.slope / p.scale;
    all.slope = join == Join::blend ? all.slope + slope : std::max(all.slope, slope);
  }
  const double most = join == Join::blend ? static_cast<double>(placements.size()) : 1;
  all.range = {join == Join::blend ? most * std::min(0.0, child.range.low) : 0,
               most * std::max(0.0, child.range.high)};
  return all;
}

Compiled Repeat::compile_node(const std::vector<Node>& children, const Block& block) const {
  const Box influence = tree::support(children[0]).influence;
  std::vector<std::unique_ptr<const Kernel>> instances;
  Interval bounds{0, 0};
  for (const Placement& p : placements) {
    if (!reaches(placed(p, influence), block.box)) continue;
    Compiled one = compile_transform(p, compile(children[0], inner_block(p, block)));
    if (!one.kernel) continue;
    instances.push_back(std::move(one.kernel));
    bounds = join == Join::blend ? bounds + one.bounds : max(bounds, one.bounds);
  }
  if (instances.empty()) return {};
  return {std::make_unique<RepeatKernel>(join, std::move(instances)), outward(bounds)};
}

/// What is too thin for the largest instance is left out of all: an instance is the same wherever
/// its neighbours have been dropped.
Node Repeat::prune_node(const std::vector<Node>& children, const Box& reach,
                        double thinnest) const {
  const Box influence = tree::support(children[0]).influence;
  Repeat kept;
  kept.join = join;
  Box inner;
  double largest = 0;
  for (const Placement& p : placements) {
    largest = std::max(largest, p.scale);
    if (!reaches(placed(p, influence), reach)) continue;
    kept.placements.push_back(p);
    inner.add(seen_from(p, reach));
  }
  if (kept.placements.empty()) return nothing();
  Node child = prune(children[0], inner, thinnest / largest);
  return is_nothing(child) ? child : Node{std::move(kept), {std::move(child)}};
}

}  // namespace hoodoo::tree
