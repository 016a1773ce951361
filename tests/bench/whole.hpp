#pragma once

namespace hoodoo::bench {

/// A landscape baked to Draco tiles, all levels, against what meshoptimizer and Draco alone take
/// for the same triangles; the error pass apart.
void compare_whole();

}  // namespace hoodoo::bench
