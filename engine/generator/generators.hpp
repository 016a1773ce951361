#pragma once
#include <variant>

#include "engine/generator/arches.hpp"
#include "engine/generator/cliff_strata.hpp"
#include "engine/generator/floating_islands.hpp"
#include "engine/generator/hoodoos.hpp"
#include "engine/generator/overhangs.hpp"
#include "engine/generator/percolation_karst.hpp"
#include "engine/generator/river_canyon.hpp"
#include "engine/generator/scatter.hpp"
#include "engine/generator/sea_cliffs.hpp"
#include "engine/generator/smooth.hpp"

/// engine/generator: the scene so far -> more operations of it.
namespace hoodoo::generator {

/// Every generator there is. To add one: write <name>.hpp, name it here. A generator lists its
/// fields, and `grow` queues trees, each of which the next sees.
/// Source: Paris et al. 2019, sections 6 and 8.2.
using AnyGenerator = std::variant<SeaCliffs, RiverCanyon, PercolationKarst, Hoodoos, Scatter,
                                  Overhangs, Arches, CliffStrata, FloatingIslands, Smooth>;

}  // namespace hoodoo::generator
