#pragma once
#include "engine/tree/node.hpp"

namespace hoodoo::tree {

/// The tree with like neighbours in its blends made one node: eight or more points in a row with
/// one turbulence become `points`, as many spheres with one falloff and turbulence `spheres`. They
/// are summed first, then added to what stands before them. Points are fixed.
///
/// Unions of 64 or more trees are packed as by pack_unions.
Node pack(Node tree);

/// The tree with unions of 64 or more trees held packed, where they have a packed form: a quarter
/// of the memory, found by place, and the same bits. Points are fixed.
Node pack_unions(Node tree);

}  // namespace hoodoo::tree
