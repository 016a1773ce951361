#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/vector.hpp"
#include "engine/tree/voxels.hpp"

/// Files by OpenVDB itself, to read again.
namespace hoodoo::scene {

enum class Packing { none, zip, blosc };

/// How a file is written, and where its voxels lie: world = voxel * index + shift, turned by `turn`
/// degrees about z.
struct VdbForm {
  std::string name = "density";
  double voxel = 1;
  Vec3 shift{};
  double turn = 0;
  Packing packing = Packing::blosc;
  bool half = false;
};

/// The level set of a ball, in a band of three voxels, negative inside.
void write_ball(const std::filesystem::path& file, const Vec3& center, double radius,
                const VdbForm& form);
/// Single active voxels.
void write_voxels(const std::filesystem::path& file,
                  const std::vector<std::pair<tree::Voxel, float>>& voxels, float background,
                  const VdbForm& form);
/// An active box, both corners included, of one value over a background of 0: tiles where it is
/// large.
void write_box(const std::filesystem::path& file, const tree::Voxel& low, const tree::Voxel& high,
               float value, const VdbForm& form);
/// "sponge": 1 in a ball of 10 units where a gyroid is positive, and 0 away from it, in half
/// precision.
void write_sponge(const std::filesystem::path& file);
/// Three grids: "mask" of truth values, "velocity" of vectors, "depth" of double precision; and,
/// if asked for, "density", twice by one tree, with another place the second time.
void write_mixed(const std::filesystem::path& file, bool with_density);
/// "density" as a stream that cannot be searched.
void write_stream(const std::filesystem::path& file);
/// "density" behind a camera's frustum.
void write_frustum(const std::filesystem::path& file);

}  // namespace hoodoo::scene
