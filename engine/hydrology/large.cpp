#include "engine/hydrology/large.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/error.hpp"
#include "engine/dem/raster.hpp"
#include "engine/hydrology/accessibility.hpp"
#include "engine/hydrology/row_sizes.hpp"
#include "engine/hydrology/sea_distance.hpp"

namespace hoodoo::hydrology {
namespace {

/// For each cell along the borders of parts, in the graph that joins them.
constexpr double bytes_of_border = 72;
constexpr std::size_t rows_written_at_once = 256;

Grid sized(const dem::RasterInfo& info) {
  Grid grid;
  grid.width = static_cast<std::int32_t>(info.width);
  grid.height = static_cast<std::int32_t>(info.height);
  set_row_sizes(grid, info);
  return grid;
}

}  // namespace

LargeDem::LargeDem(const std::filesystem::path& dem, const Options& options)
    : dem_(dem),
      memory_(options.memory),
      folder_(options.folder),
      most_rows_(options.rows),
      elevations_(options.folder) {
  read();
}

void LargeDem::read() {
  const auto raster = dem::Raster::open(dem_);
  const auto& info = raster->info();
  if (std::max(info.width, info.height) > 1 << 24) {
    throw Error(Fault::limit, dem_.string(),
                fmt::format("has {} x {} pixels; sides of {} are the most", info.width, info.height,
                            1 << 24));
  }
  auto grid = sized(info);
  width_ = grid.width, height_ = grid.height;
  dx_ = std::move(grid.dx), dy_ = std::move(grid.dy);
  require_room();
  // A row of blocks stays decoded while its rows are read.
  const auto block = raster->block();
  const auto across = static_cast<std::size_t>((info.width + block.width - 1) / block.width);
  raster->keep(std::min(block.bytes * across, memory_ / 2));
  std::vector<double> row;
  std::vector<float> values(static_cast<std::size_t>(width_));
  for (std::int32_t j = 0; j < height_; ++j) {
    raster->read(0, j, width_, 1, row);
    std::ranges::transform(row, values.begin(),
                           [&](double z) { return static_cast<float>(z * info.vertical_unit); });
    elevations_.write<float>(cell(j), values);
  }
}

std::int32_t LargeDem::rows_that_fit(std::size_t memory, std::size_t bytes) const {
  const auto row = static_cast<double>(width_);
  const double writing = row * sizeof(float) * static_cast<double>(rows_written_at_once);
  const double rows = (static_cast<double>(memory) - writing) / (row * static_cast<double>(bytes));
  return static_cast<std::int32_t>(
      std::clamp(rows - 2, 0.0, static_cast<double>(std::min(height_, most_rows_))));
}

/// The most rows that leave room for the graph of all borders; 0 if none do.
std::int32_t LargeDem::rows_to_fill(std::size_t memory) const {
  const auto row = static_cast<double>(width_);
  for (auto rows = rows_that_fit(memory, bytes_to_fill); rows > 0; rows = rows * 7 / 8) {
    const double parts = std::ceil(static_cast<double>(height_) / rows);
    const double graph = parts > 1 ? 2 * row * parts * bytes_of_border : 0;
    const double free = static_cast<double>(memory) - graph;
    if (free > 0 && rows_that_fit(static_cast<std::size_t>(free), bytes_to_fill) >= rows)
      return rows;
  }
  return 0;
}

void LargeDem::require_room() const {
  const auto enough = [&](std::size_t memory) {
    return rows_that_fit(memory, bytes_to_work) >= 1 && rows_to_fill(memory) >= 1;
  };
  if (enough(memory_)) return;
  auto needed = memory_;
  while (!enough(needed)) needed += std::max<std::size_t>(needed / 16, std::size_t{1} << 20);
  throw Error(Fault::limit, dem_.string(),
              fmt::format("has {} x {} pixels, which need {} MiB of memory; {} are allowed", width_,
                          height_, (needed >> 20) + 1, memory_ >> 20));
}

std::vector<Rows> LargeDem::parts(std::int32_t rows) const {
  std::vector<Rows> result;
  for (std::int32_t j = 0; j < height_; j += rows)
    result.push_back({j, std::min(j + rows, height_)});
  return result;
}

LargeDem::Part LargeDem::part_of(const Scratch& elevations, Rows rows, std::int32_t reach) const {
  const auto from = std::max(rows.from - reach, 0), to = std::min(rows.to + reach, height_);
  Part part{{}, {rows.from - from, rows.to - from}, from};
  part.grid.width = width_;
  part.grid.height = to - from;
  part.grid.dx.assign(dx_.begin() + from, dx_.begin() + to);
  part.grid.dy.assign(dy_.begin() + from, dy_.begin() + to);
  part.grid.z.resize(cells(to - from));
  elevations.read<float>(cell(from), part.grid.z);
  return part;
}

void LargeDem::slope(const TakeRows& take) {
  for (const auto& rows : parts()) {
    const auto part = part_of(elevations_, rows, 1);
    const auto values = hydrology::slope(part.grid);
    take(std::span(values).subspan(cells(part.rows.from), cells(rows.to - rows.from)));
  }
}

void LargeDem::accessibility(double most, const TakeRows& take) {
  Grid sizes;
  sizes.dx = dx_, sizes.dy = dy_;
  const auto reach = std::min(accessibility_reach(sizes, most), height_);
  const auto rows_held = rows_that_fit(memory_, bytes_to_work);
  // What lies in reach above and below counts as rows that are held.
  const auto inner = rows_held >= height_ ? height_ : rows_held - 2 * reach;
  if (inner < 1) {
    const double bytes = (2.0 * reach + 3) * width_ * static_cast<double>(bytes_to_work);
    throw Error(Fault::limit, dem_.string(),
                fmt::format("balls of {} m reach {} rows up and down, which need {:.0f} MiB of "
                            "memory; {} are allowed",
                            most, reach, std::ceil(bytes / (1 << 20)) + 1, memory_ >> 20));
  }
  for (const auto& rows : parts(inner)) {
    const auto part = part_of(elevations_, rows, reach);
    take(hydrology::accessibility(part.grid, most, part.rows));
  }
}

void LargeDem::sea_distance(double sea_level, const TakeRows& take) {
  Scratch steps(folder_);
  const auto wide = static_cast<std::size_t>(width_);
  std::vector<float> z(wide);
  std::vector<std::int32_t> row(wide);
  bool sea = false;
  for (std::int32_t j = 0; j < height_; ++j) {
    elevations_.read<float>(cell(j), z);
    steps_in_row(z, sea_level, row);
    sea = sea || (row[0] & ~missing) != no_sea;
    steps.write<std::int32_t>(cell(j), row);
  }
  if (!sea) {
    throw Error(Fault::bad_input, dem_.string(),
                fmt::format("has nothing at or below the sea level of {} m", sea_level));
  }
  const auto high = static_cast<std::size_t>(height_);
  const std::size_t most =
      std::clamp<std::size_t>(memory_ / 2 / (sizeof(std::int32_t) * high), 1, wide);
  for (std::size_t first = 0; first < wide; first += most) {
    const std::size_t columns = std::min(most, wide - first);
    std::vector<std::int32_t> strip(columns * high);
    for (std::size_t j = 0; j < high; ++j) {
      steps.read<std::int32_t>(j * wide + first, std::span(strip).subspan(j * columns, columns));
    }
    steps_to_distances(strip, columns, dx_, dy_);
    for (std::size_t j = 0; j < high; ++j) {
      steps.write<std::int32_t>(j * wide + first,
                                std::span<const std::int32_t>(strip).subspan(j * columns, columns));
    }
  }
  for (std::int32_t j = 0; j < height_; ++j) {
    steps.read<float>(cell(j), z);  // the bits of distances
    take(z);
  }
}

}  // namespace hoodoo::hydrology
