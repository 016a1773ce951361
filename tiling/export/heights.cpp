#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/export/image.hpp"
#include "tiling/export/raster.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

constexpr double most_pixels_across = 1'000'000;
constexpr double most_band_bytes = 1 << 30;
constexpr double largest_value = 65535, no_data = 0;

/// The pixels that the region has ground in common with, else the tiles.
Canvas canvas_of(const Selection& selection, double pixel, const std::optional<Region>& region) {
  const Box box = selection.box();
  const Region area = region.value_or(Region{box.min.x, box.min.y, box.max.x, box.max.y});
  const double west = std::floor(area.west / pixel), east = std::ceil(area.east / pixel);
  const double south = std::floor(area.south / pixel), north = std::ceil(area.north / pixel);
  const double width = std::max(1.0, east - west), height = std::max(1.0, north - south);
  const double band = width * 8 * selection.spacing() * selection.bake().lattice.tile_cells / pixel;
  const double reach = std::max({std::abs(west), std::abs(east), std::abs(south), std::abs(north)});
  if (!(width <= most_pixels_across && height <= most_pixels_across && band <= most_band_bytes &&
        reach < 1e12)) {
    throw Error(Fault::limit, "--pixel",
                fmt::format("{} m would make {:.0f} x {:.0f} pixels, {:.3g} MiB for a row of "
                            "tiles; up to {:.0f} x {:.0f} and {:.0f} MiB can be",
                            pixel, width, height, band / (1 << 20), most_pixels_across,
                            most_pixels_across, most_band_bytes / (1 << 20)));
  }
  const auto whole = [](double value) { return static_cast<std::int64_t>(value); };
  Canvas canvas{pixel, whole(west), whole(south), whole(width), whole(height)};
  canvas.scale = (box.max.z - box.min.z) / (largest_value - 1);
  if (!(canvas.scale > 0)) canvas.scale = selection.step();
  canvas.offset = box.min.z - canvas.scale;
  return canvas;
}

std::vector<std::uint16_t> values_of(std::span<const double> heights, const Canvas& canvas) {
  std::vector<std::uint16_t> values;
  values.reserve(heights.size());
  for (const double height : heights) {
    const double value = std::floor((height - canvas.offset) / canvas.scale + 0.5);
    values.push_back(static_cast<std::uint16_t>(
        std::isfinite(height) ? std::clamp(value, 1.0, largest_value) : no_data));
  }
  return values;
}

/// Rows of tiles from north to south; a pixel belongs to the row that has its centre.
void draw(const Selection& selection, const Canvas& canvas, Rows& rows) {
  const double side = selection.spacing() * selection.bake().lattice.tile_cells;
  const auto below = [&](std::int64_t row) {  // the first pixel of a row of tiles
    const double pixels = static_cast<double>(row) * side / canvas.pixel - 0.5;
    return static_cast<std::int64_t>(std::ceil(pixels));
  };
  const std::vector<std::uint16_t> blank(static_cast<std::size_t>(canvas.width));
  auto end = canvas.y + canvas.height;  // rows from here on are written
  const auto blank_down_to = [&](std::int64_t y) {
    for (; end > y; --end) rows.add(blank);
  };
  const auto& tiles = selection.tiles();
  for (auto to = tiles.end(); to != tiles.begin();) {
    const auto row = (*std::prev(to))->key.y;
    const auto from = std::ranges::partition_point(
        tiles, [&](const tileset::Record* record) { return record->key.y < row; });
    const auto first = std::max(canvas.y, below(row)), last = std::min(end, below(row + 1));
    if (first < last) {
      blank_down_to(last);
      Raster raster(canvas, first, last - first);
      for (auto at = from; at != to; ++at) raster.paint(selection.read(**at));
      for (; end > first; --end) rows.add(values_of(raster.row(end - 1), canvas));
    }
    to = from;
  }
  blank_down_to(canvas.y);
}

std::string description(const Selection& selection, const Canvas& canvas) {
  const auto& frame = selection.bake().frame;
  const auto at = [&](std::int64_t pixels) { return static_cast<double>(pixels) * canvas.pixel; };
  const nlohmann::json json{
      {"hoodoo", 1},
      {"level", selection.level()},
      {"width", canvas.width},
      {"height", canvas.height},
      {"pixel", canvas.pixel},
      {"region",
       {at(canvas.x), at(canvas.y), at(canvas.x + canvas.width), at(canvas.y + canvas.height)}},
      {"offset", canvas.offset},
      {"scale", canvas.scale},
      {"nodata", no_data},
      {"lowest", canvas.offset + canvas.scale},
      {"highest", canvas.offset + canvas.scale * largest_value},
      {"frame",
       {{"crs", frame.crs}, {"unit", frame.unit}, {"origin", {frame.origin_x, frame.origin_y}}}}};
  return json.dump(1) + "\n";
}

}  // namespace

Report write_heights(const Selection& selection, const fs::path& file, Image image, double pixel,
                     const std::optional<Region>& region) {
  const Canvas canvas = canvas_of(selection, pixel, region);
  const auto rows =
      image == Image::png ? open_png(file, canvas) : open_tif(file, canvas, selection.bake().frame);
  draw(selection, canvas, *rows);
  rows->finish();
  auto sidecar = file;
  sidecar += ".json";
  write_file(sidecar, description(selection, canvas));
  Report report;
  report.files = {file, sidecar};
  report.width = canvas.width;
  report.height = canvas.height;
  return report;
}

}  // namespace hoodoo::exporting
