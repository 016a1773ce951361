#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/hydrology/hydrology.hpp"
#include "engine/hydrology/sets.hpp"

namespace hoodoo::hydrology {

/// Finds the sinks of a raster that is fed row by row, from the first to the last. Holds three
/// rows, and some bytes for each piece of level ground without a lower neighbour and of drowned
/// ground.
class SinkFinder {
 public:
  explicit SinkFinder(std::int32_t width);

  /// `z` and `filled` [m]: elevations before and after filling; NaN where there is none. `area`
  /// [m^2]: of a cell.
  void add(std::span<const float> z, std::span<const float> filled, double area);
  /// After the last row, once. In the order of their first cells.
  std::vector<Sink> finish();

  std::size_t bytes() const;

 private:
  static constexpr std::uint32_t none = 0xffffffff;
  /// A row with a cell more at both ends, so that every cell has all its neighbours.
  struct Row {
    std::vector<float> z, filled;
    std::vector<std::uint32_t> bottom, water;  // numbers of sets, or none
    double area = 0;
  };
  /// Level ground that may be a sink, from its first cell.
  struct Bottom {
    std::int32_t i, j;
    float z, filled;
    std::uint32_t water;
    bool leaks;  // to a lower neighbour, the edge or a hole
  };

  Row row_of(std::span<const float> z, std::span<const float> filled, double area) const;
  void find_sets(const Row& below);
  bool is_low(std::size_t i, const Row& below) const;
  void place_in_water(std::size_t i);
  void place_on_bottom(std::size_t i);
  std::uint32_t join_bottoms(std::uint32_t a, std::uint32_t b);
  std::uint32_t join_waters(std::uint32_t a, std::uint32_t b);

  std::size_t width_;
  std::int32_t row_ = 0;  // of `now_`
  Row above_, now_;
  bool any_ = false;
  Sets bottoms_, waters_;
  std::vector<Bottom> bottom_;  // by set
  std::vector<double> areas_;   // [m^2] of water, by set
};

}  // namespace hoodoo::hydrology
