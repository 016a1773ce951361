#include "tiling/export/export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/error.hpp"
#include "tiling/archive/archive.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/tileset/manifest.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, Format>, 9> formats{{{"obj", Format::obj},
                                                                      {"ply", Format::ply},
                                                                      {"glb", Format::glb},
                                                                      {"gltf", Format::gltf},
                                                                      {"vdb", Format::vdb},
                                                                      {"png", Format::png},
                                                                      {"tif", Format::tif},
                                                                      {"tiff", Format::tif},
                                                                      {"3tz", Format::archive}}};

/// The .3tz of a finished bake.
Report write_archive(const fs::path& folder, const fs::path& file) {
  tileset::expect_bake(folder);
  if (!tileset::read_manifest(folder).complete) {
    throw Error(Fault::bad_input, folder.string(), "holds a bake that is not finished");
  }
  Report report;
  report.files = {file};
  report.packed = archive::pack(folder, file);
  return report;
}

/// Options that the format has no use for are mistakes of whoever gave them.
void check(Format format, const Settings& settings) {
  const auto refuse = [](const char* option, const char* why) {
    return Error(Fault::bad_input, option, why);
  };
  const bool heights = format == Format::png || format == Format::tif;
  if (settings.voxel && format != Format::vdb) throw refuse("--voxel", "is for a VDB alone");
  if (settings.pixel && !heights) throw refuse("--pixel", "is for a height map alone");
  if (format == Format::archive && (settings.level != 0 || settings.region)) {
    throw refuse(settings.region ? "--region" : "--level",
                 "cannot be chosen of a .3tz, which holds all of the tileset");
  }
}

}  // namespace

Format format_of(const fs::path& file, const std::string& name) {
  auto wanted = name;
  if (wanted.empty()) {
    wanted = file.extension().string();
    if (!wanted.empty()) wanted.erase(0, 1);
    std::ranges::transform(wanted, wanted.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
  }
  for (const auto& [known, format] : formats) {
    if (known == wanted) return format;
  }
  throw Error(Fault::bad_input, name.empty() ? file.string() : "--format",
              fmt::format("must {} obj, ply, glb, gltf, vdb, png, tif or 3tz, got \"{}\"",
                          name.empty() ? "end in" : "be", wanted));
}

Report run(const fs::path& folder, const fs::path& file, Format format, const Settings& settings) {
  check(format, settings);
  if (format == Format::archive) return write_archive(folder, file);
  const Selection selection(folder, settings);
  const double voxel = settings.voxel.value_or(selection.spacing());
  const double pixel = settings.pixel.value_or(selection.spacing());
  const auto write = [&] {
    switch (format) {
      case Format::obj:
        return write_obj(selection, file);
      case Format::ply:
        return write_ply(selection, file);
      case Format::glb:
      case Format::gltf:
        return write_gltf(selection, file, format == Format::glb);
      case Format::vdb:
        return write_vdb(selection, file, voxel);
      case Format::png:
        return write_heights(selection, file, Image::png, pixel, settings.region);
      case Format::tif:
        return write_heights(selection, file, Image::tif, pixel, settings.region);
      case Format::archive:
        break;
    }
    return Report{};
  };
  auto report = write();
  report.tiles = selection.tiles().size();
  return report;
}

nlohmann::json to_json(const Report& report) {
  nlohmann::json files = nlohmann::json::array();
  for (const auto& file : report.files) files.push_back(file.string());
  nlohmann::json result{{"files", files}};
  const auto put = [&](const char* key, auto value) {
    if (value > 0) result[key] = value;
  };
  put("tiles", report.tiles);
  put("vertices", report.vertices);
  put("triangles", report.triangles);
  put("voxels", report.voxels);
  put("width", report.width);
  put("height", report.height);
  put("packed", report.packed);
  return result;
}

}  // namespace hoodoo::exporting
