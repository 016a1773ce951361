#pragma once
#include <filesystem>
#include <string>

#include "tiling/export/export.hpp"
#include "tiling/export/selection.hpp"

/// One function per format: what `run` says of it, of this selection, into `file`.
namespace hoodoo::exporting {

Report write_obj(const Selection& selection, const std::filesystem::path& file);
Report write_ply(const Selection& selection, const std::filesystem::path& file);
/// `binary`: one .glb, else a .gltf with its buffer beside it.
Report write_gltf(const Selection& selection, const std::filesystem::path& file, bool binary);
Report write_vdb(const Selection& selection, const std::filesystem::path& file, double voxel);

/// What a height map covers: pixels [first, first + count) of the grid whose lines are multiples
/// of `pixel` [m].
struct Canvas {
  double pixel = 1;
  std::int64_t x = 0, y = 0, width = 0, height = 0;
  double offset = 0, scale = 1;  // a value v > 0 is the height offset + scale v [m]
};
enum class Image { png, tif };
Report write_heights(const Selection& selection, const std::filesystem::path& file, Image image,
                     double pixel, const std::optional<Region>& region);

}  // namespace hoodoo::exporting
