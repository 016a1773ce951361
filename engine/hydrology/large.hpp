#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/hydrology/grid.hpp"
#include "engine/hydrology/hydrology.hpp"
#include "engine/hydrology/scratch.hpp"

namespace hoodoo::hydrology {

/// Takes the rows of a raster from the first to the last, some at a time.
using TakeRows = std::function<void(std::span<const float>)>;

/// A DEM of any size and what engine/hydrology finds of it, in bounded memory: rows that fit are
/// worked on at a time, and the rest waits in temporary files of up to 21 bytes a cell. The results
/// are the bits that the functions of hydrology.hpp give of the whole grid.
///
/// Errors of all members: io, naming the folder; those of dem::Raster.
class LargeDem {
 public:
  struct Options {
    std::size_t memory = std::size_t{1} << 30;  // [bytes] that it may take
    std::filesystem::path folder;               // of its temporary files
    std::int32_t rows = std::int32_t{1} << 24;  // at most so many at a time
  };
  /// Reads the DEM. Errors: limit, telling how much memory would do.
  LargeDem(const std::filesystem::path& dem, const Options& options);

  std::int32_t width() const { return width_; }
  std::int32_t height() const { return height_; }

  void slope(const TakeRows& take);
  /// Errors: limit, where the rows in reach do not fit.
  void accessibility(double most, const TakeRows& take);
  /// Errors: bad_input, where there is no sea.
  void sea_distance(double sea_level, const TakeRows& take);
  void filled(const TakeRows& take);
  /// Errors: limit, where there are more than memory holds.
  std::vector<Sink> sinks();

  /// Area that drains through each cell.
  struct Flow {
    Routing routing = Routing::freeman;
    double exponent = 1.1;
  };
  /// The water that leaves [m^2].
  double accumulate(const Flow& flow);
  /// What `accumulate` found, and the stream power by it.
  void area(const TakeRows& take);
  void stream_power(const TakeRows& take);

 private:
  /// For a cell at the peak: to fill; to find receivers and areas with elevations and all else.
  static constexpr std::size_t bytes_to_fill = 20, bytes_to_work = 24;

  /// Rows with those beside them that exist; `rows` counts in the grid.
  struct Part {
    Grid grid;
    Rows rows;
    std::int32_t first;  // row of the raster that is the grid's first
  };
  Part part_of(const Scratch& elevations, Rows rows, std::int32_t reach) const;
  std::uint64_t cell(std::int32_t row) const {
    return static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(width_);
  }
  std::size_t cells(std::int32_t rows) const { return static_cast<std::size_t>(cell(rows)); }
  std::vector<Rows> parts(std::int32_t rows) const;
  std::vector<Rows> parts() const { return parts(rows_that_fit(memory_, bytes_to_work)); }
  std::int32_t rows_that_fit(std::size_t memory, std::size_t bytes) const;
  std::int32_t rows_to_fill(std::size_t memory) const;
  void require_room() const;
  void read();

  void fill();
  void route(Routing routing);
  void cross_flats(Routing routing, Scratch& steps);
  void settle_all(double exponent, Scratch& per_weight);
  struct Settled {
    std::size_t now, left;  // cells
  };
  Settled settle(Rows rows, double exponent, Scratch& per_weight);
  double outflow(const Scratch& per_weight) const;

  std::filesystem::path dem_;
  std::size_t memory_;
  std::filesystem::path folder_;
  std::int32_t most_rows_;
  std::int32_t width_ = 0, height_ = 0;
  std::vector<double> dx_, dy_;  // by row
  Scratch elevations_;
  std::unique_ptr<Scratch> filled_, receivers_, area_;
};

}  // namespace hoodoo::hydrology
