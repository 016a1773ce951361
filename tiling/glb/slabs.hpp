#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tiling/glb/glb.hpp"

namespace hoodoo::glb {

/// A content as several of at most `most` triangles of surface each, one above the other: slabs of
/// z, lowest first, as few as it takes and of nearly equal size. They part the finished triangles,
/// each by its mean height, and keep their order, their vertices and the origin: no position is
/// added, and where two slabs meet they share theirs to the bit. Triangles of the skirt go with the
/// triangle of the surface that they hang from, `hosts` by number. One content is given back as it
/// is.
std::vector<Content> slabs(const Content& content, std::span<const std::uint32_t> hosts,
                           std::size_t most);

/// What slabs hold, as one tile again: surface after surface, skirt after skirt, from the first
/// one's origin. There must be at least one; all have one step.
Decoded join(std::vector<Decoded> slabs);

}  // namespace hoodoo::glb
