#pragma once
#include <array>
#include <cstdint>

namespace hoodoo::surface {

/// Numbering of a lattice cell, used throughout this folder.
/// Corner x + 2 y + 4 z. Edge 4 a + u + 2 v runs along axis a, offset by u and v along the axes
/// after it. Face 2 a + s lies across axis a on its low (0) or high (1) side; its corners in cyclic
/// order are (u,v) = 00, 10, 11, 01 along the axes after a, and its edge k joins corners k, k+1.
constexpr std::size_t next_axis(std::size_t axis) { return axis == 2 ? 0 : axis + 1; }
constexpr std::size_t last_axis(std::size_t axis) { return axis == 0 ? 2 : axis - 1; }

/// How the surface passes a cell: one sheet per loop of crossed edges.
struct Case {
  std::array<std::int8_t, 12> sheet{};   // of each edge; -1 where it is not crossed
  std::array<std::uint16_t, 4> edges{};  // of each sheet, one bit per edge
  int sheets = 0;
  int bad_face = -1;  // an ambiguous face both of whose segments lie in one sheet
};

/// Cases by the solid corners of a cell, one bit each. On an ambiguous face each solid corner is
/// cut off alone. Sheets are numbered by their lowest edge.
const std::array<Case, 256>& cases();
/// The same with the bad face re-paired so that its empty corners are cut off instead.
const std::array<Case, 256>& flipped_cases();

/// One line of a lattice face's dual contour: the two face edges it joins.
struct Segment {
  int first, second;
};
/// The segments of a face whose corner k is solid where bit k of `corners` is set, in the pairing
/// of `cases`; two, ordered by solid corner, where the face is ambiguous.
struct FaceCase {
  std::array<Segment, 2> segments{};
  int count = 0;
};
FaceCase face_case(unsigned corners);

}  // namespace hoodoo::surface
