#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tiling/glb/draco.hpp"

namespace hoodoo::glb {

/// Elements of a buffer view as EXT_meshopt_compression holds them, version 0 of its bit streams.
struct Packed {
  std::vector<unsigned char> bytes;
  std::size_t count = 0, stride = 0;
  std::string mode, filter;  // as the extension names them
};

/// Triangles in an order that reuses vertices, and vertices in the order of their first use.
Primitive reordered(const Primitive& primitive);

/// Positions as whole steps with one exponent: they decode to the same floats. `step` is a power of
/// two. Errors: limit, when a coordinate needs more than 23 bits of steps.
Packed pack_positions(const Primitive& primitive, double step);
/// Ten octahedral bits, as four normalised shorts each of which the last tells nothing.
Packed pack_normals(const Primitive& primitive);
Packed pack_colors(const Primitive& primitive);
/// Of four bytes each.
Packed pack_materials(const Primitive& primitive);
Packed pack_triangles(const Primitive& primitive);

/// The view that stands for `packed`, whose bytes are `view` of buffer 0, in the fallback buffer
/// that nobody stores, at `offset`.
nlohmann::json packed_view(const nlohmann::json& view, const Packed& packed, std::size_t offset);

/// What such a view holds. Errors: bad_input naming `where`.
std::vector<std::byte> unpack(std::span<const std::byte> bytes, const nlohmann::json& extension,
                              const std::string& where);

}  // namespace hoodoo::glb
