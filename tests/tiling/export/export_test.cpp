#include "tiling/export/export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <nlohmann/json.hpp>

#include "engine/base/error.hpp"
#include "engine/base/file.hpp"
#include "tests/tiling/export/mesh_files.hpp"
#include "tests/tiling/tileset/world.hpp"

namespace hoodoo::exporting {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using shapes::Folder;
using shapes::World;
using testing::HasSubstr;

constexpr std::uintmax_t most = 1 << 30;

/// A folder with a bake, and one for what is made of it.
struct Export : testing::Test {
  Folder folder{"export-bake"}, out{"export"};
  tileset::Bake bake;

  void bake_world(const World& world) {
    bake = world.make(folder.path);
    tileset::write_index(bake, tileset::estimate_errors(bake), folder.path);
  }
  void SetUp() override { bake_world(World{}); }

  fs::path write(const std::string& name, const Settings& settings = {}) {
    const auto file = out.path / name;
    report = run(folder.path, file, format_of(file, ""), settings);
    return file;
  }
  Error refusal(const std::string& name, const Settings& settings = {}) {
    try {
      write(name, settings);
    } catch (const Error& error) {
      return error;
    }
    return {Fault::internal, "", "was not refused"};
  }
  /// Sum over the records of a level.
  std::uint64_t sum(std::uint64_t tileset::Record::*member, int level = 0) const {
    std::uint64_t total = 0;
    for (const auto& record : bake.records) {
      if (record.key.level == level) total += record.*member;
    }
    return total;
  }

  Report report;
};

TEST_F(Export, WeldsALevelSoThatOnlyTheWorldsEdgeIsOpen) {
  for (int level = 0; level < 2; ++level) {
    const auto mesh = read_ply(write("a.ply", {.level = level}));
    EXPECT_EQ(mesh.patch.triangles.size(), sum(&tileset::Record::triangles, level));
    EXPECT_EQ(mesh.open_edges(), sum(&tileset::Record::world_edges, level));
    EXPECT_EQ(mesh.positions(), mesh.patch.points.size());
    EXPECT_EQ(report.vertices, mesh.patch.points.size());
    EXPECT_EQ(report.triangles, mesh.patch.triangles.size());
    EXPECT_EQ(report.tiles, std::size_t{1} << 2 * (1 - level));
  }
}

TEST_F(Export, GivesObjAndPlyTheSameMesh) {
  const auto ply = read_ply(write("a.ply"));
  const auto obj = read_obj(write("a.obj"));
  EXPECT_EQ(obj.patch.points, ply.patch.points);
  EXPECT_EQ(obj.open_edges(), ply.open_edges());
  std::map<std::string, int> in_obj, in_ply;
  for (const auto& name : obj.materials) ++in_obj[name];
  for (const auto& name : ply.materials) ++in_ply[name];
  EXPECT_EQ(in_obj["shale"], in_ply["0"]);
  EXPECT_EQ(in_obj["chalk"], in_ply["1"]);
  EXPECT_GT(in_ply["1"], 0);
  for (std::size_t i = 0; i < obj.normals.size(); ++i) {
    EXPECT_NEAR(length(obj.normals[i] - ply.normals[i]), 0, 1e-5);
  }
}

TEST_F(Export, TellsPlyReadersTheMaterialsAndGivesColoursInSrgb) {
  const auto ply = read_ply(write("a.ply"));
  EXPECT_THAT(ply.header, HasSubstr("comment material 0 #8d8377 shale\n"));
  EXPECT_THAT(ply.header, HasSubstr("comment material 1 #f0f0e6 chalk\n"));
  // The tiles' green is 100 of 255 in linear light: IEC 61966-2-1 makes it 168.
  EXPECT_EQ(ply.colors.front()[1], 168);
}

TEST_F(Export, WritesALibraryOfMaterialsBesideAnObj) {
  bake.materials[0].name = bake.materials[1].name = "wet rock";
  tileset::write_index(bake, tileset::estimate_errors(bake), folder.path);
  const auto file = write("my.obj");
  ASSERT_EQ(report.files.size(), 2U);
  EXPECT_EQ(report.files[1], out.path / "my.mtl");
  EXPECT_THAT(read_file(file, most), HasSubstr("\nmtllib my.mtl\n"));
  const auto library = read_file(out.path / "my.mtl", most);
  EXPECT_THAT(library, HasSubstr("newmtl wet_rock\nKd 0.552941 0.513725 0.466667\n"));
  EXPECT_THAT(library, HasSubstr("newmtl wet_rock_2\n")) << "names without spaces, told apart";
}

TEST_F(Export, WritesAGlbThatIsReadAsATileIs) {
  const auto file = write("a.glb");
  const auto text = read_file(file, most);
  const auto bytes = std::as_bytes(std::span(text));
  const auto tile = glb::read({bytes.begin(), bytes.end()}, 0, "");
  EXPECT_EQ(tile.surface.triangles.size(), sum(&tileset::Record::triangles));
  EXPECT_TRUE(tile.skirt.triangles.empty());
  MeshFile mesh;
  std::map<std::array<double, 3>, std::uint32_t> named;
  tileset::Patch split;
  tileset::add(split, tile, {});
  const auto name = [&](std::uint32_t v) {
    const auto& p = split.points[v];
    const auto fresh = static_cast<std::uint32_t>(named.size());
    return named.try_emplace({p.x, p.y, p.z}, fresh).first->second;
  };
  for (const auto& [a, b, c] : split.triangles) {
    mesh.patch.triangles.push_back({name(a), name(b), name(c)});
    EXPECT_EQ(tile.surface.materials[a], tile.surface.materials[b]);
  }
  EXPECT_EQ(mesh.open_edges(), sum(&tileset::Record::world_edges));
  EXPECT_EQ(named.size(), read_ply(write("a.ply")).patch.points.size());
  EXPECT_GT(split.points.size(), named.size()) << "split where materials meet";
}

TEST_F(Export, PutsTheBufferOfAGltfBesideIt) {
  const auto file = write("a.gltf");
  const auto gltf = json::parse(read_file(file, most));
  EXPECT_EQ(gltf["buffers"][0]["uri"], "a.bin");
  EXPECT_EQ(gltf["buffers"][0]["byteLength"], fs::file_size(out.path / "a.bin"));
  EXPECT_EQ(gltf["meshes"].size(), 1U);
  EXPECT_FALSE(gltf.contains("extensionsRequired"));
}

TEST_F(Export, TakesTheTilesThatARegionTouches) {
  // Tiles have 16 m; the region reaches a little into the second column, and up to the second row.
  const auto mesh = read_ply(write("a.ply", {.region = Region{10, 3, 16.5, 16}}));
  EXPECT_EQ(report.tiles, 2U);
  Box box;
  for (const auto& p : mesh.patch.points) box.add(p);
  EXPECT_EQ(box.min.x, 0);
  EXPECT_EQ(box.max.x, 32);
  EXPECT_EQ(box.max.y, 16);
}

TEST_F(Export, JoinsRegionsSideBySideWithoutAGap) {
  const auto west = read_ply(write("a.ply", {.region = Region{0, 0, 16, 32}}));
  const auto east = read_ply(write("a.ply", {.region = Region{16, 0, 32, 32}}));
  const auto border = [](const MeshFile& mesh) {
    std::set<std::array<double, 3>> points;
    for (const auto& p : mesh.patch.points) {
      if (p.x == 16) points.insert({p.x, p.y, p.z});
    }
    return points;
  };
  EXPECT_EQ(border(west), border(east));
  EXPECT_GE(border(west).size(), 32U);
}

TEST_F(Export, GivesTheSameBytesOnOneThreadAndOnEight) {
  for (const char* name : {"a.obj", "a.ply", "a.glb", "a.vdb", "a.png", "a.tif", "a.3tz"}) {
    std::string before;
    for (const int threads : {1, 8}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
      const auto bytes = read_file(write(name), most);
      EXPECT_TRUE(before.empty() || before == bytes) << name;
      before = bytes;
    }
  }
}

TEST_F(Export, LeavesNothingBesideTheFiles) {
  for (const char* name : {"a.obj", "a.ply", "a.gltf", "a.vdb", "a.png", "a.tif", "a.3tz"}) {
    write(name);
    std::set<fs::path> there;
    for (const auto& entry : fs::directory_iterator(out.path)) there.insert(entry.path());
    EXPECT_EQ(there, std::set<fs::path>(report.files.begin(), report.files.end())) << name;
    for (const auto& file : there) fs::remove(file);
  }
}

TEST_F(Export, NamesTheEndingsItKnows) {
  EXPECT_EQ(format_of("a.TIFF", ""), Format::tif);
  EXPECT_EQ(format_of("a.obj", "ply"), Format::ply);
  EXPECT_THAT(refusal("a.stl").what(), HasSubstr("must end in obj, ply"));
  EXPECT_EQ(refusal("a").fault, Fault::bad_input);
}

TEST_F(Export, RefusesALevelThatIsNotThere) {
  EXPECT_THAT(refusal("a.ply", {.level = 2}).what(),
              HasSubstr("--level: must be in [0, 1], the levels of"));
  EXPECT_EQ(refusal("a.ply", {.level = -1}).fault, Fault::bad_input);
}

TEST_F(Export, RefusesARegionOutside) {
  const auto error = refusal("a.ply", {.region = Region{100, 0, 120, 20}});
  EXPECT_THAT(error.what(), HasSubstr("--region: 100,0,120,20 m has no surface of level 0"));
  EXPECT_THAT(error.what(), HasSubstr("within 0,0,32,32 m"));
  EXPECT_EQ(error.fault, Fault::bad_input);
}

TEST_F(Export, RefusesOptionsThatAFormatHasNoUseFor) {
  EXPECT_THAT(refusal("a.ply", {.voxel = 1}).what(), HasSubstr("--voxel: is for a VDB"));
  EXPECT_THAT(refusal("a.vdb", {.pixel = 1}).what(), HasSubstr("--pixel: is for a height map"));
  EXPECT_THAT(refusal("a.3tz", {.level = 1}).what(), HasSubstr("--level: cannot be chosen"));
}

TEST_F(Export, RefusesABakeThatIsNotFinished) {
  bake.records.pop_back();
  tileset::write_index(bake, tileset::estimate_errors(bake), folder.path);
  for (const char* name : {"a.ply", "a.3tz"}) {
    EXPECT_THAT(refusal(name).what(), HasSubstr("holds a bake that is not finished")) << name;
  }
}

TEST_F(Export, LeavesNoFileWhenATileIsDamaged) {
  const auto tile = folder.path / store::tile_path(bake.records.front().content);
  std::fstream(tile, std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('~');
  for (const char* name : {"a.obj", "a.ply", "a.glb", "a.vdb", "a.png", "a.tif"}) {
    EXPECT_EQ(refusal(name).fault, Fault::bad_input) << name;
    EXPECT_TRUE(fs::is_empty(out.path)) << name;
  }
}

TEST_F(Export, SaysWhereItCannotWrite) {
  write_file(out.path / "file", "");
  for (const char* name : {"file/a.obj", "file/a.vdb", "file/a.png", "file/a.3tz"}) {
    EXPECT_EQ(refusal(name).fault, Fault::io) << name;
    EXPECT_THAT(refusal(name).what(), HasSubstr((out.path / "file").string())) << name;
  }
}

}  // namespace
}  // namespace hoodoo::exporting
