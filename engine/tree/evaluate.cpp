#include "engine/tree/evaluate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "engine/tree/ball_kernel.hpp"
#include "engine/tree/combine_kernel.hpp"
#include "engine/tree/primitive_kernel.hpp"
#include "engine/tree/space_kernel.hpp"

namespace hoodoo::tree {
namespace {

template <class N>
class PatternKernel final : public Kernel {
 public:
  PatternKernel(const N& node, const Vec3& origin) : node_(node), origin_(origin) {}
  void values(const Points& at, std::span<float> out) const override {
    node_.values(origin_, at, out);
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    node_.gradients(origin_, at, out, g);
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(std::string(static_cast<std::size_t>(2 * depth), ' ') + std::string(N::type));
  }

 private:
  N node_;
  Vec3 origin_;
};

template <class N>
Compiled compile_one(const N& node, const std::vector<Node>& children, const Block& block) {
  if constexpr (Primitive<N>) {
    return compile_primitive(node, block);
  } else if constexpr (Combiner<N>) {
    std::vector<Compiled> compiled;
    compiled.reserve(children.size());
    if constexpr (requires { node.packed; }) {
      for (std::size_t i = 0; i < node.packed.size(); ++i) {
        const bool near = node.packed.reaches(i, block.box);
        compiled.push_back(near ? compile(node.packed.tree(i), block) : Compiled());
      }
    }
    for (const Node& child : children) compiled.push_back(compile(child, block));
    if (compiled.empty()) return {};
    return compile_combiner(node, std::move(compiled));
  } else if constexpr (Transform<N>) {
    return compile_transform(node, compile(children[0], inner_block(node, block)));
  } else if constexpr (Displacement<N>) {
    return compile_displacement(node, children, block);
  } else if constexpr (Composite<N>) {
    return node.compile_node(children, block);
  } else if constexpr (Swarm<N>) {
    return compile_swarm(node, block);
  } else {
    return {std::make_unique<PatternKernel<N>>(node, block.origin), node.bounds(block)};
  }
}

}  // namespace

void Kernel::cube(const Cube& at, CubeValues out, AskedRows& asked) const {
  asked.fill(1);
  std::array<float, batch_size> x, y, z;
  static_assert(batch_size == Cube::side * Cube::side);
  for (std::size_t n = 0; n < batch_size; ++n) {
    y[n] = at.y[n / Cube::side];
    z[n] = at.z[n % Cube::side];
  }
  for (std::size_t i = 0; i < at.nx; ++i) {
    x.fill(at.x[i]);
    values({x, y, z}, out.subspan(batch_size * i, batch_size));
  }
}

Compiled compile(const Node& tree, const Block& block) {
  return std::visit([&](const auto& node) { return compile_one(node, tree.children, block); },
                    tree.value);
}

double rounding(const Box& box, const Block& block) {
  double farthest_side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = block.origin[axis];
    for (const double side :
         {box.min[axis], box.max[axis], block.box.min[axis], block.box.max[axis]}) {
      farthest_side = std::max(farthest_side, std::abs(side - origin));
    }
  }
  return 2e-6 * farthest_side;
}

}  // namespace hoodoo::tree
