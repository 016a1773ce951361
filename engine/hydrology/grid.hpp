#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace hoodoo::hydrology {

/// Elevations in memory, row by row as in their file.
struct Grid {
  std::int32_t width = 0, height = 0;
  std::vector<float> z;        // [m], NaN where there is none
  std::vector<double> dx, dy;  // ground size of the cells of a row [m]

  std::size_t size() const { return z.size(); }
  std::size_t index(std::int32_t i, std::int32_t j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(i);
  }
  bool holds(std::int32_t i, std::int32_t j) const {
    return i >= 0 && j >= 0 && i < width && j < height;
  }
  bool valid(std::size_t cell) const { return !std::isnan(z[cell]); }
  double area(std::int32_t j) const {  // of a cell of row j [m^2]
    return dx[static_cast<std::size_t>(j)] * dy[static_cast<std::size_t>(j)];
  }
};

/// Rows of a raster, from the first to before the last.
struct Rows {
  std::int32_t from, to;
  friend bool operator==(const Rows&, const Rows&) = default;
};

/// The eight neighbours, counter-clockwise from the one with the next column; k and k ^ 4 lie
/// opposite each other. Every loop over them goes in this order.
inline constexpr std::array<std::int32_t, 8> next_column{1, 1, 0, -1, -1, -1, 0, 1};
inline constexpr std::array<std::int32_t, 8> next_row{0, -1, -1, -1, 0, 1, 1, 1};
constexpr unsigned opposite(unsigned k) { return k ^ 4U; }

/// Cells by number, with their neighbours.
class Neighbours {
 public:
  explicit Neighbours(const Grid& grid) : grid_(grid) {
    for (std::size_t k = 0; k < 8; ++k) {
      offset_[k] = static_cast<std::ptrdiff_t>(next_row[k]) * grid.width + next_column[k];
    }
  }
  /// Bit k: neighbour k lies in the raster.
  unsigned inside(std::size_t cell) const {
    const auto wide = static_cast<std::size_t>(grid_.width);
    const std::size_t j = cell / wide, i = cell - j * wide;
    unsigned bits = 0xff;
    if (i + 1 == wide) bits &= ~0b10000011U;
    if (i == 0) bits &= ~0b00111000U;
    if (j == 0) bits &= ~0b00001110U;
    if (j + 1 == static_cast<std::size_t>(grid_.height)) bits &= ~0b11100000U;
    return bits;
  }
  /// Bit k: neighbour k lies in the raster and has an elevation.
  unsigned valid(std::size_t cell) const {
    unsigned bits = inside(cell);
    for (unsigned k = 0; k < 8; ++k) {
      if ((bits >> k & 1) != 0 && !grid_.valid(at(cell, k))) bits &= ~(1U << k);
    }
    return bits;
  }
  std::size_t at(std::size_t cell, unsigned k) const {
    return static_cast<std::size_t>(static_cast<std::ptrdiff_t>(cell) + offset_[k]);
  }

 private:
  const Grid& grid_;
  std::array<std::ptrdiff_t, 8> offset_{};
};

}  // namespace hoodoo::hydrology
