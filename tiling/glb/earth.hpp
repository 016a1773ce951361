#pragma once
#include <string>

#include "engine/dem/earth.hpp"
#include "tiling/glb/glb.hpp"

namespace hoodoo::glb {

/// Steps of a tile that lies on the Earth to a step of its lattice, which is turned there: so fine
/// that no two points meet, and that each is found again.
inline constexpr int finer = 4;

/// The content in the rigid frame of `earth`: every point through the map and snapped, normals
/// turned by the map's Jacobian. A function of each point alone, so that neighbours still meet.
/// Errors: as `Earth::places`.
Content on_earth(const Content& content, const dem::Earth& earth);

/// What `read` gave of such a tile, on the lattice of the scene again, whose step is `step` [m].
/// Errors: bad_input naming `where`, when a point is none of that lattice.
Decoded from_earth(const Decoded& tile, const dem::Earth& earth, double step,
                   const std::string& where);

/// A box of the scene around all that lies in `box` of the rigid frame: between its corners the map
/// bends by less than a sphere of 6,000 km would.
Box scene_box(const Box& box, const dem::Earth& earth);

}  // namespace hoodoo::glb
