#include "engine/tree/reach.hpp"

#include <algorithm>
#include <type_traits>
#include <variant>

#include "engine/tree/ball_kernel.hpp"
#include "engine/tree/region.hpp"

namespace hoodoo::tree {
namespace {

void join(Reach& reach, const Interval& z) {
  if (z.low > z.high) return;
  reach.z = {std::min(reach.z.low, z.low), std::max(reach.z.high, z.high)};
}

Reach of_box(const Box& influence, const Box& column) {
  Reach reach;
  const Box both = intersection(influence, column);
  if (!both.empty()) join(reach, {both.min.z, both.max.z});
  return reach;
}

template <Swarm N>
Reach of_balls(const N& node, const Box& column) {
  Reach reach;
  const Vec3 middle = (column.min + column.max) * 0.5;
  const double margin = node.margin() * (1 + 5e-5) + 4e-6 * farthest_side(column, middle);
  const double stretch = node.stretch() * (1 + 5e-5);
  const Balls held = node.balls.part(column, stretch, margin);
  for (const auto& found : held.near(column, stretch, margin)) {
    const double far = found.ball->radius * stretch + margin;
    join(reach, {found.ball->z - far, found.ball->z + far});
  }
  return reach;
}

}  // namespace

Reach reach_over(const Node& tree, const Box& column) {
  return std::visit(
      [&](const auto& node) {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (Swarm<N>) {
          return of_balls(node, column);
        } else if constexpr (std::is_same_v<N, Blend> || std::is_same_v<N, Union>) {
          Reach reach;
          if constexpr (std::is_same_v<N, Union>) {
            for (std::size_t i = 0; i < node.packed.size(); ++i) {
              if (!node.packed.reaches(i, column)) continue;
              join(reach, reach_over(node.packed.tree(i), column).z);
            }
          }
          for (const Node& child : tree.children) join(reach, reach_over(child, column).z);
          return reach;
        } else {
          return of_box(support(tree).influence, column);
        }
      },
      tree.value);
}

Reach reach_over(const Step& step, const Box& column) {
  Box part = column;
  if (step.region) part = intersection(part, step.region->influence());
  return part.empty() ? Reach{} : reach_over(step.tree, part);
}

}  // namespace hoodoo::tree
