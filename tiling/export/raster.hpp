#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tiling/export/formats.hpp"
#include "tiling/glb/glb.hpp"

namespace hoodoo::exporting {

/// Some rows of a canvas, and the highest surface over each pixel's centre.
class Raster {
 public:
  /// Rows [first, first + count) of the pixel grid, from the south.
  Raster(const Canvas& canvas, std::int64_t first, std::int64_t count);

  /// Adds a tile's surface. Triangles that share an edge leave no pixel out between them.
  void paint(const glb::Decoded& tile);
  /// The heights of row `y` of the grid [m], from the west; -infinity where there is no surface.
  std::span<const double> row(std::int64_t y) const;

 private:
  struct Corner {
    double x, y, z;  // in pixels from the first one's centre; [m]
  };
  void paint(const Corner& a, const Corner& b, const Corner& c);

  const Canvas& canvas_;
  std::int64_t first_, count_;
  std::vector<double> heights_;
};

}  // namespace hoodoo::exporting
