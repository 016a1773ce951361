#pragma once

namespace hoodoo::bench {

/// A maximal set of spheres in a shell under a surface beside plain dart throwing.
void compare_sampling();

}  // namespace hoodoo::bench
