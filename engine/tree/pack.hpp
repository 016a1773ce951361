#pragma once
#include "engine/tree/node.hpp"

namespace hoodoo::tree {

/// The tree with like neighbours in its blends made one node: eight or more points in a row with
/// one turbulence become `points`, as many spheres with one falloff and turbulence `spheres`. They
/// are summed first, then added to what stands before them. Points are fixed.
Node pack(Node tree);

}  // namespace hoodoo::tree
