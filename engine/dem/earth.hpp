#pragma once
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/base/vector.hpp"
#include "engine/dem/dem.hpp"

namespace hoodoo::dem {

/// The scene frame on the Earth: every point through PROJ to EPSG:4978 (earth-centred,
/// earth-fixed), seen from one rigid frame that lies at the scene's origin, at height 0, its axes
/// east, north and up there [m]. Not one rigid turn of the projected coordinates: 10 km away that
/// would be 7.8 m off, and a map's scale with it.
///
/// Safe for any number of threads. PROJ's results end in the C library's rounding, and no byte may
/// (see source_map.hpp): it is asked at the corners of a lattice of 256 m only, its answers are
/// rounded to 2^-12 m, and between the corners goes a cubic through 4 x 4 of them. Along z the map
/// is straight: a height moves a point along the ellipsoid's normal. Off PROJ by less than 1 mm.
class Earth {
 public:
  /// Errors: bad_input, when the frame has no CRS, one is unknown, or no way leads from it to the
  /// Earth, as where a vertical datum's grid is missing.
  explicit Earth(const Frame& frame);
  ~Earth();
  Earth(Earth&&) noexcept;
  Earth& operator=(Earth&&) noexcept;

  /// A point of the scene in the rigid frame, and how it moves there by metre of x, y and z.
  struct Place {
    Vec3 at;
    std::array<Vec3, 3> axes;
  };
  /// Errors: bad_input naming a point that PROJ cannot place.
  std::vector<Place> places(std::span<const Vec3> scene) const;
  /// The points of the scene that lie there, to a hundredth of a millimetre.
  std::vector<Vec3> scene(std::span<const Vec3> local) const;

  /// From the rigid frame to EPSG:4978, column by column, as 3D Tiles writes it.
  std::array<double, 16> transform() const;

 private:
  struct Operation;
  class Lattice;
  std::unique_ptr<Operation> operation_;
  Vec3 origin_;               // EPSG:4978 [m]
  std::array<Vec3, 3> turn_;  // east, north, up
};

/// That of a frame whose tiles lie on the Earth.
inline std::optional<Earth> earth_of(const Frame& frame) {
  return frame.vertical.empty() ? std::nullopt : std::optional<Earth>(std::in_place, frame);
}

}  // namespace hoodoo::dem
