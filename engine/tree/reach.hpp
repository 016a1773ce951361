#pragma once
#include "engine/base/box.hpp"
#include "engine/base/interval.hpp"
#include "engine/tree/ground.hpp"

namespace hoodoo::tree {

/// Where a tree or a step can matter over a part of the ground: the bounds that Paris et al. 2019,
/// section 7, ask a construction tree for.
struct Reach {
  Interval z{Box::infinity, -Box::infinity};  // [m]; empty (low > high) where nothing reaches
  bool empty() const { return z.low > z.high; }
};

/// The z at which `tree` can differ from 0 somewhere in `column` [m]. Points are fixed.
Reach reach_over(const Node& tree, const Box& column);
/// That of the step's tree where its region lets it act.
Reach reach_over(const Step& step, const Box& column);

}  // namespace hoodoo::tree
