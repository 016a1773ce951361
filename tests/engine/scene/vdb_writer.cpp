#include "tests/engine/scene/vdb_writer.hpp"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace hoodoo::scene {
namespace {

openvdb::math::Transform::Ptr placed(const VdbForm& form) {
  auto transform = openvdb::math::Transform::createLinearTransform(form.voxel);
  if (form.turn != 0)
    transform->postRotate(form.turn * 3.14159265358979 / 180, openvdb::math::Z_AXIS);
  transform->postTranslate({form.shift.x, form.shift.y, form.shift.z});
  return transform;
}

void write(const std::filesystem::path& path, const openvdb::GridPtrVec& grids, Packing packing) {
  openvdb::io::File file(path.string());
  std::uint32_t flags = openvdb::io::COMPRESS_NONE;
  if (packing == Packing::zip) {
    flags = openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK;
  } else if (packing == Packing::blosc) {
    flags = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;
  }
  file.setCompression(flags);
  file.write(grids);
  file.close();
}

void write(const std::filesystem::path& path, const openvdb::FloatGrid::Ptr& grid,
           const VdbForm& form) {
  grid->setName(form.name);
  grid->setSaveFloatAsHalf(form.half);
  write(path, openvdb::GridPtrVec{grid}, form.packing);
}

openvdb::Coord coord(const tree::Voxel& v) { return {v[0], v[1], v[2]}; }

openvdb::FloatGrid::Ptr dot() {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName("density");
  grid->getAccessor().setValue({1, 2, 3}, 4);
  return grid;
}

}  // namespace

void write_ball(const std::filesystem::path& file, const Vec3& center, double radius,
                const VdbForm& form) {
  openvdb::initialize();
  auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      static_cast<float>(radius), openvdb::Vec3f(openvdb::Vec3d(center.x, center.y, center.z)),
      static_cast<float>(form.voxel));
  grid->transform().postTranslate({form.shift.x, form.shift.y, form.shift.z});
  write(file, grid, form);
}

void write_voxels(const std::filesystem::path& file,
                  const std::vector<std::pair<tree::Voxel, float>>& voxels, float background,
                  const VdbForm& form) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(background);
  auto accessor = grid->getAccessor();
  for (const auto& [at, value] : voxels) accessor.setValue(coord(at), value);
  grid->setTransform(placed(form));
  write(file, grid, form);
}

void write_box(const std::filesystem::path& file, const tree::Voxel& low, const tree::Voxel& high,
               float value, const VdbForm& form) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->fill({coord(low), coord(high)}, value);
  grid->setTransform(placed(form));
  write(file, grid, form);
}

void write_sponge(const std::filesystem::path& file) {
  std::vector<std::pair<tree::Voxel, float>> voxels;
  constexpr double size = 0.8, wave = 0.55;
  for (std::int32_t i = -14; i <= 14; ++i) {
    for (std::int32_t j = -14; j <= 14; ++j) {
      for (std::int32_t k = -14; k <= 14; ++k) {
        const double x = wave * size * i, y = wave * size * j, z = wave * size * k;
        const double gyroid =
            std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x);
        const double depth = 10 - size * std::sqrt(i * i + j * j + k * k);
        const double value = std::clamp(0.5 + std::min(gyroid, depth / 2), 0.0, 1.0);
        if (value > 0) voxels.push_back({{i, j, k}, static_cast<float>(value)});
      }
    }
  }
  write_voxels(file, voxels, 0, {.name = "sponge", .voxel = size, .half = true});
}

void write_mixed(const std::filesystem::path& file, bool with_density) {
  openvdb::initialize();
  openvdb::GridPtrVec grids;
  auto mask = openvdb::BoolGrid::create(false);
  mask->setName("mask");
  mask->getAccessor().setValue({0, 0, 0}, true);
  auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  auto depth = openvdb::DoubleGrid::create();
  depth->setName("depth");
  grids = {mask, velocity, depth};
  if (with_density) {
    const auto density = dot();
    auto again = density->copy();  // shares the tree
    again->setName("again");
    again->setTransform(openvdb::math::Transform::createLinearTransform(2));
    grids.insert(grids.end(), {density, again});
  }
  write(file, grids, Packing::zip);
}

void write_stream(const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  openvdb::io::Stream(out).write(openvdb::GridPtrVec{dot()});
}

void write_frustum(const std::filesystem::path& file) {
  auto grid = dot();
  grid->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10));
  write(file, openvdb::GridPtrVec{grid}, Packing::none);
}

}  // namespace hoodoo::scene
