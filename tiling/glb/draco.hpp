#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/base/vector.hpp"

namespace hoodoo::glb {

/// A primitive in the axes and units of the glTF file.
struct Primitive {
  std::vector<std::array<float, 3>> positions;  // [m], multiples of the step
  std::vector<Vec3f> normals;
  std::vector<std::array<std::uint8_t, 4>> colors;
  std::vector<std::uint16_t> materials;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Widest material id that is written as one byte.
inline constexpr std::uint16_t most_short_id = 255;

/// A primitive as the buffer of KHR_draco_mesh_compression.
struct Compressed {
  std::vector<unsigned char> bytes;
  std::size_t vertices = 0, triangles = 0;  // as encoded
  std::map<std::string, int> attributes;    // glTF name -> id in the buffer
};

/// Compresses with explicit quantisation: the grid of `step` anchored at the lowest corner, in as
/// few bits as hold the extent, so that every position decodes to the same float. Normals take 10
/// octahedral bits; colours and material ids are lossless. `wide_ids`: ids of two bytes.
/// `speed` of the encoder: 0 smallest to 10 fastest; 5 encodes 2 to 4 million triangles a second.
/// Errors: limit, when 23 bits of steps do not hold the extent, or 24 a coordinate; internal, when
/// a number is not finite or the encoder refuses.
Compressed compress(const Primitive& primitive, double step, bool wide_ids, int speed);

/// Decodes what `compress` made, by the ids under which the glTF names the attributes.
/// Errors: bad_input naming `where`.
Primitive decompress(std::span<const std::byte> bytes, const std::map<std::string, int>& attributes,
                     const std::string& where);

}  // namespace hoodoo::glb
