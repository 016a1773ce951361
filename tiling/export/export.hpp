#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

/// tiling/export: a finished bake -> one file for other programs. (`export` is a keyword, so the
/// namespace has another name than the folder.)
namespace hoodoo::exporting {

enum class Format { obj, ply, glb, gltf, vdb, png, tif, archive };

/// The format called `name` ("obj", "ply", "glb", "gltf", "vdb", "png", "tif", "3tz"), or where
/// that is empty, the one that the file's ending stands for. Errors: bad_input.
Format format_of(const std::filesystem::path& file, const std::string& name);

/// A rectangle of ground in the scene frame [m].
struct Region {
  double west = 0, south = 0, east = 0, north = 0;
};

struct Settings {
  int level = 0;                      // 0 is the finest
  std::optional<Region> region = {};  // all of the world where there is none
  std::optional<double> voxel = {};   // side [m] of a voxel of a VDB; the level's spacing
  std::optional<double> pixel = {};   // side [m] of a pixel of a height map; the level's spacing
};

struct Report {
  std::vector<std::filesystem::path> files;   // written, the one asked for first
  std::uint64_t tiles = 0;                    // read
  std::uint64_t vertices = 0, triangles = 0;  // of a mesh
  std::uint64_t voxels = 0;                   // active ones of a level set
  std::int64_t width = 0, height = 0;         // of a height map [pixels]
  std::uint64_t packed = 0;                   // files in an archive
};

/// Exports the surface of one level of the finished bake in `folder`, or of a part of it, without
/// skirts.
///
/// A mesh is one piece: vertices at the same position are one, whatever tiles they come from, so
/// that an edge has one face only where the level ends. It is in metres of the scene frame, z up
/// (glTF: y up, as it must be), counter-clockwise seen from the air. A region gives every tile
/// whose ground it touches, whole, so that exports of tiles side by side join without a gap.
///   obj   groups of faces by material, in FILE.mtl beside it; positions to the last bit.
///   ply   binary; double positions, a colour per vertex (sRGB, of one of the materials that meet
///         there), the material's number per face; comments name them.
///   glb, gltf   one mesh in the profile `plain`, attributes and materials as in a tile (vertices
///         are split where materials meet, at one position). Positions are floats, exact up to 2^24
///         steps from the middle.
///   vdb   a level set, negative inside. The solid is closed by upright walls where the surface
///         ends and by a floor four voxels below its lowest point; caves without a way out are
///         hollow.
/// A height map shows the highest surface over the centre of each pixel, north up, in 16 bits: 0
/// where there is none, else `offset` + `scale` times the value [m]. A region is cut to whole
/// pixels, which lie at multiples of their side. FILE.json beside it tells offset, scale, place and
/// CRS; a TIFF has them in its tags, too. The range of values is that of the tiles' boxes.
/// A .3tz is the whole tileset as it is; it has no level and no region.
///
/// A level is complete by itself: it covers all ground, so that no other level is needed where
/// tiles are few. Same bake and settings, same bytes.
///
/// Memory: obj and ply hold a tile and the border of a row of tiles (ply puts faces in a temporary
/// file beside its own); a height map a row of tiles' pixels; 3tz a file at a time. glb, gltf and
/// vdb hold the whole mesh several times over, and vdb the narrow band: they grow with what is
/// exported. All hold the index of the bake.
///
/// Errors: bad_input for what is no finished bake, a level or region that it does not have, a file
/// that is damaged; limit, when a format cannot hold it; not_found, io.
Report run(const std::filesystem::path& folder, const std::filesystem::path& file, Format format,
           const Settings& settings = {});

/// {"files", "tiles", and what the format has of "vertices", "triangles", "voxels", "width",
/// "height", "packed"}.
nlohmann::json to_json(const Report& report);

}  // namespace hoodoo::exporting
