#include "engine/tree/nodes/erosion.hpp"

#include "engine/tree/composite.hpp"

namespace hoodoo::tree {
namespace {

enum Part : std::size_t { resistance, control, child };

class ErosionKernel final : public Kernel {
 public:
  ErosionKernel(const Erosion& node, std::array<std::unique_ptr<const Kernel>, 3> parts)
      : node_(node), parts_(std::move(parts)) {}

  void values(const Points& at, std::span<float> out) const override {
    const std::size_t n = at.size();
    std::array<float, batch_size> rho, weight;
    put_values(parts_[resistance].get(), at, {rho.data(), n});
    put_values(parts_[control].get(), at, {weight.data(), n});
    put_values(parts_[child].get(), at, out);
    for (std::size_t i = 0; i < n; ++i) out[i] = node_.worn(out[i], rho[i], weight[i]);
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const std::size_t n = at.size();
    Slopes rho, weight, f;
    put_gradients(parts_[resistance].get(), at, rho.values(n), rho.spans(n));
    put_gradients(parts_[control].get(), at, weight.values(n), weight.spans(n));
    put_gradients(parts_[child].get(), at, f.values(n), f.spans(n));
    for (std::size_t i = 0; i < n; ++i) {
      put(node_.worn(f.at(i), rho.at(i), weight.at(i)), i, out, g);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, Erosion::type));
    for (const auto& part : parts_) {
      if (part) part->explain(depth + 1, lines);
    }
  }

 private:
  Erosion node_;
  std::array<std::unique_ptr<const Kernel>, 3> parts_;
};

}  // namespace

Support Erosion::support(std::span<const Support> children) const {
  Support all{Box(), {0, 0}, 0};
  if (children.size() > child) all = children[child];
  const double most = amount * std::clamp(children[control].range.high, 0.0, 1.0);
  const double softest = 1 - std::clamp(children[resistance].range.low, 0.0, 1.0);
  all.influence.add(children[control].influence);
  all.range.low -= most * softest;
  if (amount > 0) all.slope += amount * (children[resistance].slope + children[control].slope);
  return all;
}

Compiled Erosion::compile_node(const std::vector<Node>& children, const Block& block) const {
  std::array<Compiled, 3> parts;
  for (std::size_t i = 0; i < children.size(); ++i) parts[i] = compile(children[i], block);
  // Nothing is worn where the control field is 0.
  if (!parts[control].kernel) return std::move(parts[child]);
  const Interval bounds =
      worn(parts[child].bounds, parts[resistance].bounds, parts[control].bounds);
  return {std::make_unique<ErosionKernel>(
              *this, std::array{std::move(parts[resistance].kernel),
                                std::move(parts[control].kernel), std::move(parts[child].kernel)}),
          outward(bounds)};
}

Node Erosion::prune_node(const std::vector<Node>& children, const Box& reach,
                         double thinnest) const {
  Node body = children.size() > child ? prune(children[child], reach, thinnest) : nothing();
  Node where = prune(children[control], reach, 0);
  if (is_nothing(where)) return body;
  Node pruned{*this, {prune(children[resistance], reach, 0), std::move(where)}};
  if (!is_nothing(body)) pruned.children.push_back(std::move(body));
  return pruned;
}

}  // namespace hoodoo::tree
