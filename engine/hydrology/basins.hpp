#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Ground by where its water runs to, and how high it must rise to go on.
///
/// From each cell a path leads to the lowest neighbour, of equal ones the first, over and over: it
/// never rises. Cells whose paths end at one cell are a basin; those whose paths end where water
/// leaves are outside. So a cell's water leaves at its own elevation or at that at which its
/// basin spills, whichever is higher; and the levels at which basins spill are those of the lowest
/// ways through the graph of their passes.
namespace hoodoo::hydrology {

inline constexpr std::uint32_t outside = 0;

/// The lowest way from one basin into another; some may be stated several times.
struct Pass {
  std::uint32_t a, b;
  float level;  // [m]
};

/// The higher of two cells; of one and none, that one.
inline float higher(float a, float b) { return b > a || a != a ? b : a; }

/// Levels at which basins spill: of the ways to the outside, the lowest highest pass. `outside` has
/// minus infinity; those without a way, plus infinity. Sorts `passes`.
std::vector<float> spill_levels(std::vector<Pass>& passes, std::uint32_t basins);

/// As few passes, of basins below `kept` alone, with the same lowest ways between them.
std::vector<Pass> contracted(std::vector<Pass>& passes, std::uint32_t basins, std::uint32_t kept);

/// Whole rows of a raster. Beyond its first and last row there is more ground, or none.
struct Ground {
  std::span<float> z;  // [m], NaN where there is none
  std::size_t width;
  bool above = false, below = false;

  std::size_t height() const { return z.size() / width; }
};

class Basins {
 public:
  /// A cell of the first row with more ground above, or of the last with more below, is a basin of
  /// its own, unless it lies outside: what lies beyond decides where its water goes.
  explicit Basins(const Ground& ground);

  std::uint32_t count() const { return count_; }
  /// Below this number: the outside, and cells of the first and last row.
  std::uint32_t on_borders() const { return on_borders_; }
  std::uint32_t at(std::size_t cell) const { return basin_[cell]; }
  std::vector<Pass>& passes() { return passes_; }
  /// Raises cells to the levels of their basins.
  void raise(std::span<const float> levels);

 private:
  void descend();
  void part_border(std::size_t j);
  void descend_from_row(std::size_t j, std::vector<std::uint8_t>& where);
  void follow();
  void find_passes();

  Ground ground_;
  std::uint32_t count_ = 1, on_borders_ = 1;
  std::vector<std::uint32_t> basin_;  // by cell; before it is known, the next cell of the path
  std::vector<Pass> passes_;
};

}  // namespace hoodoo::hydrology
