#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tiling/volume/volume.hpp"

namespace hoodoo::volume {

/// The signs of a block's points: bit x of row 16 z + y.
using SignRows = std::span<std::uint16_t, 256>;

/// Solid below elevations: those of column (x, y) at 17 y + x; the points of layer k lie at
/// z + k * spacing [m].
void find_signs(std::span<const double, 289> elevations, double z, double spacing, SignRows rows);
/// Solid above 1/2: the value of point (x, y, z) at 256 x + 16 y + z.
void find_signs(std::span<const float, 4096> values, SignRows rows);

/// Of sixteen values those above `iso`, one bit each.
unsigned find_signs(std::span<const float, 16> values, float iso);

/// Finds the crossed edges of a block from the signs of its points and of those beside it, and
/// numbers their crossings: `near[a][y]` and `layers[a]` are the edges along axis a that count, one
/// bit per x of row y, one per layer. Says how many there are.
std::size_t find_crossed(const Volume::Rows& rows,
                         const std::array<std::array<std::uint16_t, 16>, 3>& near,
                         const std::array<unsigned, 3>& layers, Block& block);

/// Unit vectors against (x, y, z), in single precision; 0 where there is no direction. The bits of
/// normalized.
void point_against(std::span<const double> x, std::span<const double> y, std::span<const double> z,
                   const std::array<std::span<float>, 3>& out);

/// Where a crossing is put that its owner's values do not bracket: so far from an end.
inline constexpr double nearest_end = 1.0 / 256;

/// RootFinder for many edges, one per lane.
class RootLanes {
 public:
  static constexpr std::size_t spare = 8;

  /// `low[i]` and `high[i]` are the values at the ends of edge `edges[i]` less the iso value; their
  /// signs differ.
  void start(std::span<const std::uint32_t> edges, std::span<const double> low,
             std::span<const double> high);

  /// Edges that are not done, and where to evaluate each next.
  std::span<const std::uint32_t> edges() const { return {edges_.data(), n_}; }
  std::span<const double> places();
  /// Takes the values there less the iso value; `spare` more may be read beyond them, and not used.
  /// The roots of those that are done go to `roots`, by edge; of the others something else does.
  void put(std::span<const double> values, std::span<double> roots);

  /// What RootFinder holds of each edge.
  struct Brackets {
    double *low, *high, *f_low, *f_high, *side;
  };

 private:
  void resize(std::size_t n);
  Brackets brackets();

  std::size_t n_ = 0;
  int steps_ = 0;
  std::vector<std::uint32_t> edges_;
  std::vector<double> low_, high_, f_low_, f_high_, side_, place_, done_;
};

}  // namespace hoodoo::volume
