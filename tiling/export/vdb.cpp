#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "engine/base/error.hpp"
#include "engine/base/file_writer.hpp"
#include "engine/base/hash.hpp"
#include "tiling/export/formats.hpp"
#include "tiling/export/shells.hpp"
#include "tiling/export/solid.hpp"
#include "tiling/export/weld.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;

constexpr float half_width = 3;       // of the narrow band [voxels]
constexpr double depth = 4;           // of the floor below the surface [voxels]
constexpr double most_band = 4e9;     // voxels
constexpr double farthest = 1 << 22;  // from the origin [voxels]: a float then has a quarter
constexpr std::uint64_t most_vertices = 4'000'000'000;

/// Gathers all pieces, in metres.
struct Gathered {
  double step;
  tileset::Patch patch;

  void add(const Piece& piece) {
    if (patch.points.size() + piece.points.size() > most_vertices) {
      throw Error(Fault::limit, "", "a VDB takes a mesh of up to 4000000000 vertices");
    }
    for (const auto& p : piece.points) {
      const auto at = [&](std::size_t a) { return static_cast<double>(p[a]) * step; };
      patch.points.push_back({at(0), at(1), at(2)});
    }
    for (const auto& [a, b, c] : piece.triangles) {
      patch.triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                                 static_cast<std::uint32_t>(c)});
    }
  }
};

void check(const tileset::Patch& patch, double voxel) {
  double reach = 0, area = 0;
  for (const auto& p : patch.points) {
    reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  for (const auto& [a, b, c] : patch.triangles) {
    const Vec3& p = patch.points[a];
    area += length(cross(patch.points[b] - p, patch.points[c] - p)) / 2;
  }
  const double band = area / (voxel * voxel) * 2 * static_cast<double>(half_width);
  if (band > most_band || reach / voxel > farthest) {
    throw Error(Fault::limit, "--voxel",
                fmt::format("{} m would make a narrow band of about {:.3g} voxels, {:.3g} voxels "
                            "from the origin at most; up to {:.3g} and {:.3g} can be",
                            voxel, band, reach / voxel, most_band, farthest));
  }
}

openvdb::FloatGrid::Ptr level_set(const tileset::Patch& patch, double voxel) {
  std::vector<openvdb::Vec3s> points;
  points.reserve(patch.points.size());
  for (const auto& p : patch.points) points.emplace_back(openvdb::Vec3d(p.x, p.y, p.z));
  std::vector<openvdb::Vec3I> triangles;
  triangles.reserve(patch.triangles.size());
  for (const auto& [a, b, c] : patch.triangles) triangles.emplace_back(a, b, c);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  return openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles,
                                                            half_width);
}

/// OpenVDB finds the inside from the outside alone, so cavities are taken out afterwards.
openvdb::FloatGrid::Ptr level_set(const Shells& shells, double voxel) {
  auto grid = level_set(shells.solids, voxel);
  if (!shells.cavities.triangles.empty()) {
    openvdb::tools::csgDifference(*grid, *level_set(shells.cavities, voxel));
  }
  if (!shells.inner.triangles.empty()) {
    openvdb::tools::csgUnion(*grid, *level_set(shells.inner, voxel));
  }
  return grid;
}

/// OpenVDB gives each file a UUID by chance. It takes one from the content instead, so that the
/// same grid gives the same bytes. Its 36 digits follow the magic number, three versions and a
/// flag.
void name_by_content(const fs::path& file) {
  constexpr std::streamoff place = 8 + 3 * 4 + 1;
  constexpr std::size_t digits = 36;
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(place + static_cast<std::streamoff>(digits));
  Sha256 hash;
  std::vector<char> buffer(std::size_t{1} << 20);
  while (stream.read(buffer.data(), std::ssize(buffer)) || stream.gcount() > 0) {
    hash.add({buffer.data(), static_cast<std::size_t>(stream.gcount())});
  }
  const auto hex = hash.finish().hex();
  const auto part = [&](std::size_t from, std::size_t count) { return hex.substr(from, count); };
  // Version 8, variant 1: of a form of one's own. RFC 9562, section 5.8.
  const auto uuid =
      part(0, 8) + "-" + part(8, 4) + "-8" + part(13, 3) + "-8" + part(17, 3) + "-" + part(20, 12);
  stream.clear();
  stream.seekp(place);
  stream.write(uuid.data(), std::ssize(uuid));
  if (!stream.flush()) throw Error(Fault::io, file.string(), "cannot be written");
}

void write(const openvdb::FloatGrid::Ptr& grid, const fs::path& file) {
  FileWriter target(file);
  try {
    openvdb::io::File output(target.temporary().string());
    output.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
    output.write(openvdb::GridPtrVec{grid});
    output.close();
  } catch (const openvdb::Exception& error) {
    throw Error(Fault::io, file.string(), std::string("cannot be written: ") + error.what());
  }
  name_by_content(target.temporary());
  target.commit();
}

}  // namespace

Report write_vdb(const Selection& selection, const fs::path& file, double voxel) {
  openvdb::initialize();
  Gathered mesh{selection.step(), {}};
  weld(selection, false, mesh);
  Report report;
  report.files = {file};
  report.vertices = mesh.patch.points.size();
  report.triangles = mesh.patch.triangles.size();
  double low = Box::infinity;
  for (const auto& p : mesh.patch.points) low = std::min(low, p.z);
  check(mesh.patch, voxel);
  auto shells = sort_shells(mesh.patch);
  mesh.patch = {};
  close(shells.solids, low - depth * voxel);
  const auto grid = level_set(shells, voxel);
  grid->setName("surface");
  grid->setCreator("hoodoo " + selection.bake().engine);
  report.voxels = grid->activeVoxelCount();
  write(grid, file);
  return report;
}

}  // namespace hoodoo::exporting
