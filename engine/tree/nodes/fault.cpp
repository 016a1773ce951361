#include "engine/tree/nodes/fault.hpp"

#include "engine/tree/composite.hpp"
#include "engine/tree/space_kernel.hpp"

namespace hoodoo::tree {
namespace {

/// w: turned, then moved.
struct Motion {
  static constexpr std::string_view type = "moved";
  Rotate turn;
  Vec3 by;

  explicit Motion(const Fault& fault) : turn{fault.axis, fault.angle, fault.pivot}, by(fault.by) {}
  Matrix inward() const { return turn.inward(); }
  Vec3 to_child(const Vec3& p) const { return turn.to_child(p - by); }
  Vec3 from_child(const Vec3& p) const { return turn.from_child(p) + by; }
};

class FaultKernel final : public Kernel {
 public:
  FaultKernel(std::unique_ptr<const Kernel> domain, std::unique_ptr<const Kernel> outside,
              std::unique_ptr<const Kernel> inside)
      : domain_(std::move(domain)), outside_(std::move(outside)), inside_(std::move(inside)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> domain, inside;
    domain_->values(at, {domain.data(), n});
    put_values(inside_.get(), at, {inside.data(), n});
    put_values(outside_.get(), at, out);
    for (std::size_t i = 0; i < n; ++i) out[i] = domain[i] > 0.5F ? inside[i] : out[i];
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> domain;
    Slopes inside;
    domain_->values(at, {domain.data(), n});
    put_gradients(inside_.get(), at, inside.values(n), inside.spans(n));
    put_gradients(outside_.get(), at, out, g);
    for (std::size_t i = 0; i < n; ++i) {
      if (domain[i] > 0.5F) put(inside.at(i), i, out, g);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, Fault::type));
    for (const Kernel* part : {domain_.get(), outside_.get(), inside_.get()}) {
      if (part != nullptr) part->explain(depth + 1, lines);
    }
  }

 private:
  std::unique_ptr<const Kernel> domain_, outside_, inside_;
};

}  // namespace

Support Fault::support(std::span<const Support> children) const {
  Support all = children[0];
  const Motion motion(*this);
  all.influence.add(
      mapped(children[0].influence, [&](const Vec3& p) { return motion.from_child(p); }));
  if (all.slope > 0) all.slope = Support::no_bound;  // it jumps at the domain's edge
  return all;
}

Compiled Fault::compile_node(const std::vector<Node>& children, const Block& block) const {
  const Motion motion(*this);
  Compiled domain = compile(children[1], block);
  if (!domain.kernel || domain.bounds.high <= 0.5) return compile(children[0], block);
  Compiled inside = compile_transform(motion, compile(children[0], inner_block(motion, block)));
  if (domain.bounds.low > 0.5) return inside;
  Compiled outside = compile(children[0], block);
  if (!inside.kernel && !outside.kernel) return {};
  return {std::make_unique<FaultKernel>(std::move(domain.kernel), std::move(outside.kernel),
                                        std::move(inside.kernel)),
          hull(inside.bounds, outside.bounds)};
}

Node Fault::prune_node(const std::vector<Node>& children, const Box& reach, double thinnest) const {
  Node domain = prune(children[1], reach, 0);
  if (is_nothing(domain)) return prune(children[0], reach, thinnest);
  const Motion motion(*this);
  Box both = reach;
  both.add(mapped(reach, [&](const Vec3& p) { return motion.to_child(p); }));
  Node child = prune(children[0], both, thinnest);
  return is_nothing(child) ? child : Node{*this, {std::move(child), std::move(domain)}};
}

}  // namespace hoodoo::tree
