#pragma once
#include <variant>

#include "engine/scene/brushes/arch.hpp"
#include "engine/scene/brushes/cave.hpp"
#include "engine/scene/brushes/curve.hpp"
#include "engine/scene/brushes/sphere.hpp"
#include "engine/scene/brushes/tunnel.hpp"

namespace hoodoo::scene {

/// Every brush there is. To add one: write brushes/<name>.hpp, name it here. A brush lists its
/// fields; `op` says how it joins what is there, and `build()` makes its tree once its points are
/// fixed.
/// Source: Paris et al. 2019, section 8.2 (skeletal brushes, procedural arches and caves).
using AnyBrush = std::variant<SphereBrush, CurveBrush, TunnelBrush, ArchBrush, CaveBrush>;

}  // namespace hoodoo::scene
