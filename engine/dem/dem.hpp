#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"
#include "engine/base/interval.hpp"
#include "engine/dem/raster.hpp"
#include "engine/dem/window.hpp"

/// engine/dem: GeoTIFF -> Pyramid, chunked elevations in the scene frame, on disk.
namespace hoodoo::dem {

/// The scene frame: x east, y north [m], `origin` subtracted from projected coordinates.
struct Frame {
  std::string crs;      // PROJ definition (EPSG:32632, or WKT2) of a projected CRS; "" is local
  double unit = 1;      // metres per unit of that CRS
  double origin_x = 0;  // projected coordinates [m] of the scene's (0, 0):
  double origin_y = 0;  // multiples of the level-0 spacing
  /// What heights count from, where the tiles lie on the Earth (earth.hpp): "ellipsoid" or a
  /// vertical CRS; "" where the tiles lie in the scene frame itself.
  std::string vertical{};
  friend bool operator==(const Frame&, const Frame&) = default;
};

/// The frame that DESIGN section 2 gives a scene whose first terrain is `first`, and its default
/// level-0 spacing: the smaller ground size of a pixel at the raster's centre [m], rounded to a
/// multiple of `step(it)`. `spacing` replaces the default when given (already rounded).
struct Placement {
  Frame frame;
  double spacing;
};
Placement place(const Raster& first, std::optional<double> spacing);

/// The step of level 0: the largest power of two <= spacing / 256 [m].
double step_of(double spacing);
/// `spacing` [m] as a multiple of step_of(spacing), at least 256 steps.
double rounded_spacing(double spacing);

/// What ingesting may spend, and whom it tells.
struct IngestSettings {
  std::size_t memory = 256u << 20;  // [bytes], an upper bound for pixel buffers
  int threads = 1;
  std::stop_token stop;
  std::function<void(double)> progress;  // fraction done in [0,1]; called from any thread
};

/// Elevations [m] of one DEM in the scene frame, as levels of chunks on disk.
///
/// Level 0 has the DEM's own samples where the DEM is axis-aligned in the frame's CRS, else one
/// bicubic resampling to square pixels of the frame's default spacing; each further level averages
/// the valid ones of 2 x 2. Rows run south to north. A pixel without data is NaN on disk.
/// Safe to read from any number of threads; chunks in memory stay below a bound.
class Pyramid {
 public:
  /// Ingests `raster` into `folder`, or opens what an earlier call with the same content left
  /// there (named by the digest of file content, frame, fill). `fill` [m] replaces NoData inside
  /// the raster; without it NoData is a hole. A half-made pyramid is never opened, one that is
  /// seen to be damaged is made anew, and nothing is kept of a raster that changes meanwhile.
  /// Errors: bad_input, limit, io, cancelled.
  static std::shared_ptr<const Pyramid> ingest(const std::filesystem::path& raster,
                                               const Frame& frame, double pixel,
                                               std::optional<double> fill,
                                               const std::filesystem::path& folder,
                                               const IngestSettings& settings = {});
  virtual ~Pyramid() = default;

  /// One level's grid: pixel (i, j) covers [x0 + i dx, x0 + (i+1) dx) x [y0 + j dy, ...), and its
  /// sample stands at the centre. Coordinates in the scene frame [m].
  struct Level {
    double x0, y0, dx, dy;
    std::int64_t width, height;
  };
  virtual const std::vector<Level>& levels() const = 0;
  /// The coarsest level whose larger pixel size is at most `spacing` [m]; 0 if none is.
  int level_for(double spacing) const;

  /// File name of the raster that was ingested, for messages.
  virtual const std::string& name() const = 0;
  /// Names everything this pyramid's samples depend on.
  virtual const Digest& digest() const = 0;
  /// Box of level 0 in x and y, elevations range in z [m]. Empty when no pixel is valid.
  virtual Box extent() const = 0;

  /// Digests of the chunks that `window` would read, in a fixed order.
  virtual std::vector<Digest> chunks(int level, const Box& area) const = 0;
  /// The samples of `level` needed to evaluate anywhere in `area` (x and y; z is ignored).
  /// Errors: io when they are damaged on disk; the next `ingest` then makes them anew.
  virtual Window window(int level, const Box& area) const = 0;
  /// Bounds [m] on the elevation over `area`, from chunk minima and maxima widened by the
  /// overshoot of the bicubic; nothing when no valid pixel is near.
  virtual std::optional<Interval> bounds(int level, const Box& area) const = 0;
};

/// Errors: io, naming the raster, when it is not in the state any more that it was `before`.
void expect_unchanged(const std::filesystem::path& raster, const std::optional<FileState>& before);

}  // namespace hoodoo::dem
