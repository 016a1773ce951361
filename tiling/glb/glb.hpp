#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/tree/ground.hpp"
#include "tiling/surface/mesh.hpp"

/// tiling/glb: surface -> glTF bytes, and back.
namespace hoodoo::glb {

/// What one tile's file holds.
struct Content {
  surface::Mesh surface, skirt;          // the skirt may be empty
  std::array<std::int64_t, 3> origin{};  // of the points, in steps from the scene origin
  double step = 1;                       // [m], a power of two
  int draco_speed = 5;                   // of its encoder, 0 smallest to 10 fastest
  std::vector<tree::Material> materials;
};

/// A binary glTF 2.0: one mesh with a primitive for the surface and one for the skirt (marked in
/// its extras: {"hoodoo": {"role": "skirt"}}), y up, metres, the origin in the node's translation.
/// Positions are exact multiples of the step after decoding: `draco` uses explicit quantisation
/// with range (2^bits - 1) * step, `meshopt` whole steps with one exponent, `plain` writes float32.
/// Material ids are the feature ids of EXT_mesh_features, their names, colours, resistance and
/// friction a property table of EXT_structural_metadata. The asset's extras tell the step:
/// {"hoodoo": {"step": 0.0039}}. Same content, same bytes. Errors: limit, when the tile is larger
/// than 23 bits of steps, or a point needs more than 24.
std::vector<std::byte> write(const Content& content, std::string_view profile);

/// Vertices of all primitives in what `write` gave: Draco splits one where parts of a surface meet
/// in a point alone, so that a file can have more than its content.
std::uint64_t vertices_of(const std::vector<std::byte>& bytes);

/// A tile's file decoded.
struct Decoded {
  struct Part {
    std::vector<std::array<std::int32_t, 3>> points;  // steps from `origin`
    std::vector<Vec3f> normals;
    std::vector<std::array<std::uint8_t, 4>> colors;  // as in surface::Mesh
    std::vector<std::uint16_t> materials;
    std::vector<std::array<std::uint32_t, 3>> triangles;
  };
  Part surface, skirt;
  std::array<std::int64_t, 3> origin{};
  double step = 1;
};
enum class Wanted : std::uint8_t { all, surface };
/// Reads back what `write` wrote, or its surface alone; `step` [m] as it was then, or 0 for what
/// the file says. Errors: bad_input naming `where`, when the bytes are no such file, or a position
/// is not a multiple of the step.
Decoded read(const std::vector<std::byte>& bytes, double step, const std::string& where,
             Wanted wanted = Wanted::all);

}  // namespace hoodoo::glb
