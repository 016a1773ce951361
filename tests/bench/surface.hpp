#pragma once

namespace hoodoo::bench {

/// Field, Hermite data and surface of two landscapes against the algorithm of Paris et al. 2019.
void compare_surface();

}  // namespace hoodoo::bench
