#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/vector.hpp"
#include "tiling/slice/land.hpp"
#include "tiling/surface/surface.hpp"

namespace hoodoo::surface {

/// The surface of `volume`, sampled from `land`: polygonize with vertices that stand nearer the
/// field than the crossings alone can tell. Where the ground turns within a cell, as on a cliff a
/// sample wide, the planes at the crossings meet off the surface; Newton's step takes the vertex
/// back towards it, inside its cell. A step that does not help is not taken.
Surface extract(const volume::Volume& volume, slice::Land& land);
/// The same in the memory of `workspace`, whose surface it becomes.
const Surface& extract(const volume::Volume& volume, slice::Land& land, Workspace& workspace);

/// A surface ready to be written: one vertex per point and material, so that a triangle's three
/// vertices carry one material.
struct Mesh {
  std::vector<std::array<std::int32_t, 3>> points;  // steps from the tile's origin
  std::vector<Vec3f> normals;                       // unit
  std::vector<std::array<std::uint8_t, 4>> colors;  // linear RGB as glTF COLOR_0, alpha 255
  std::vector<std::uint16_t> materials;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Gives the surface its normals (the field's gradient at the snapped vertex), materials and
/// colours: the material's in sRGB, times 0.82 + 0.36 rho of the rock there (strata), made linear.
/// Triangles keep their order. Points without a triangle are left out.
/// `origin` is the surface's (0,0,0) in steps from the scene origin.
Mesh shade(const Surface& surface, slice::Land& land, const slice::StepPoint& origin);

/// Skirts, and the triangle of the surface that each of their triangles hangs from.
struct Skirts : Mesh {
  std::vector<std::uint32_t> hosts;
};

/// Skirts in the tile's border planes, facing out of the tile: from the border curve into the
/// solid along the inward normal of that curve in its plane (straight up or down at the tile's
/// corners and where the world ends), `depth` [m] deep, but never more than half the local
/// thickness of the solid (found by marching the field), so that they do not pierce a thin roof.
/// None along the world's edge and around holes. `mesh` is the shaded `surface`, triangle by
/// triangle. Points stand on whole steps, on a border plane and within the tile in plan; their z
/// may lie beyond the tile's cells.
Skirts skirts(const Surface& surface, const Mesh& mesh, slice::Land& land,
              const slice::StepPoint& origin, double depth);

}  // namespace hoodoo::surface
