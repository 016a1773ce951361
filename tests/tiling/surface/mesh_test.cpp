#include "tiling/surface/mesh.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/scene/sample.hpp"
#include "engine/scene/scene.hpp"

namespace hoodoo::surface {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The tile of a made-up coast that holds its plateau, in two rocks.
class Meshes : public ::testing::Test {
 protected:
  Meshes() : folder_(fs::temp_directory_path() / ("hoodoo-mesh-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    scene::SampleDem sample;
    sample.pixels = 128;
    sample.spacing = 4;
    scene::write_sample_dem(folder_ / "dem.tif", sample);
  }
  ~Meshes() override { fs::remove_all(folder_); }

  json text() const {
    return {{"hoodoo", 1},
            {"materials",
             {{{"name", "shale"}, {"color", "#bcbcbc"}, {"resistance", {0, 0.5}}},
              {{"name", "limestone"}, {"color", "#ff8000"}, {"resistance", {0.5, 1}}}}},
            {"terrains", {{{"id", "land"}, {"dem", "dem.tif"}}}},
            {"bake", {{"tile_cells", 64}}}};
  }

  /// Opens the scene and bakes one tile of it as far as its meshes.
  void make(const json& scene_text) {
    scene::OpenSettings settings;
    settings.cache = folder_ / "cache";
    const auto scene = scene::open(scene_text, {folder_, {}}, settings);
    slice_ = slice::cut(scene, {scene.spacing, dem::step_of(scene.spacing), scene.bake.tile_cells},
                        {0, 0, 0});
    slice::Land land(slice_, scene.pyramids);
    const auto volume = volume::sample(land);
    const int units = slice_.lattice.units();
    surface_ = polygonize(volume, units);
    for (std::size_t a = 0; a < 3; ++a) origin_[a] = volume.low()[a] * units;
    mesh_ = shade(surface_, land, origin_);
    skirt_ = skirts(surface_, mesh_, land, origin_, 4 * slice_.spacing());
  }

  fs::path folder_;
  slice::Slice slice_;
  slice::StepPoint origin_{};
  Surface surface_;
  Mesh mesh_, skirt_;
};

Vec3 point(const Mesh& mesh, std::uint32_t v) {
  const auto& p = mesh.points[v];
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}
Vec3 widen(const Vec3f& v) { return {v.x, v.y, v.z}; }

TEST_F(Meshes, HaveTheSurfacesTrianglesInItsOrder) {
  make(text());
  ASSERT_EQ(mesh_.triangles.size(), surface_.triangles.size());
  ASSERT_GT(mesh_.triangles.size(), 5000U);
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_EQ(mesh_.points[mesh_.triangles[t][k]], surface_.points[surface_.triangles[t][k]]);
      ASSERT_EQ(mesh_.materials[mesh_.triangles[t][k]], surface_.materials[t]);
    }
  }
}

TEST_F(Meshes, HaveOneVertexPerPointAndMaterial) {
  auto scene = text();
  scene["geology"] = {{"type", "strata"}, {"wavelength", 20}, {"octaves", 2}};
  make(scene);
  std::set<std::pair<std::array<std::int32_t, 3>, std::uint16_t>> seen;
  for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
    EXPECT_TRUE(seen.insert({mesh_.points[v], mesh_.materials[v]}).second);
  }
  EXPECT_GT(mesh_.points.size(), surface_.points.size());  // both rocks are there
}

TEST_F(Meshes, HaveUnitNormalsOnTheAirSideOfTheirTriangles) {
  make(text());
  std::size_t against = 0;
  for (const auto& t : mesh_.triangles) {
    const Vec3 a = point(mesh_, t[0]);
    const Vec3 face = cross(point(mesh_, t[1]) - a, point(mesh_, t[2]) - a);
    for (const auto v : t) {
      const Vec3 n = widen(mesh_.normals[v]);
      ASSERT_NEAR(length(n), 1, 1e-5);
      against += dot(n, face) <= 0 ? 1 : 0;
    }
  }
  // Cliffs of a few cells turn a few triangles over.
  EXPECT_LE(against, 3 * mesh_.triangles.size() / 1000);
}

/// Without a geology the resistance is 1/2, where the factor on the colour is 1.
TEST_F(Meshes, HaveTheMaterialsColorInLinearLight) {
  make(text());
  for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
    ASSERT_EQ(mesh_.materials[v], 1);
    ASSERT_EQ(mesh_.colors[v], (std::array<std::uint8_t, 4>{255, 55, 0, 255}));
  }
}

TEST_F(Meshes, HaveSkirtsAroundTheTileThatEndInRock) {
  make(text());
  const std::int32_t size = 64 * slice_.lattice.units();
  std::set<std::int32_t> sides;
  for (const auto& t : skirt_.triangles) {
    for (std::size_t a = 0; a < 2; ++a) {
      for (const std::int32_t at : {0, size}) {
        const bool on =
            std::all_of(t.begin(), t.end(), [&](auto v) { return skirt_.points[v][a] == at; });
        if (on) sides.insert(static_cast<std::int32_t>(2 * a) + (at == 0 ? 0 : 1));
      }
    }
  }
  // The tile lies in the south-west corner of the world.
  EXPECT_EQ(sides, (std::set<std::int32_t>{1, 3}));
}

/// An intersection reaches everywhere, and must not hide how far the others reach.
TEST_F(Meshes, HoldWhatOperationsMakeFarAboveAndBelowTheElevations) {
  auto scene = text();
  scene["operations"] = json::parse(R"([
    {"op": "intersect", "tree": {"type": "box", "center": [128, 128, 0], "size": [600, 600, 400]}},
    {"op": "union", "tree": {"type": "sphere", "center": [128, 100, 500], "radius": 24}}])");
  make(scene);
  std::int32_t low = mesh_.points[0][2], high = low;
  for (const auto& p : mesh_.points) {
    low = std::min(low, p[2]);
    high = std::max(high, p[2]);
  }
  EXPECT_NEAR(static_cast<double>(low + origin_[2]) * slice_.step(), -200, 0.5);
  EXPECT_NEAR(static_cast<double>(high + origin_[2]) * slice_.step(), 524, 0.5);
}

}  // namespace
}  // namespace hoodoo::surface
