// OpenVDB's own files, whole and broken, read into a scene's trees.
#include "engine/scene/vdb.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <random>

#include "engine/base/file.hpp"
#include "engine/tree/nodes/grid.hpp"
#include "tests/engine/scene/fixture.hpp"
#include "tests/engine/scene/vdb_writer.hpp"
#include "tests/engine/tree/probe.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tree::Voxel;
using tree::Voxels;

constexpr std::size_t plenty = std::size_t{1} << 26;

class Vdb : public testing::Test {
 protected:
  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  /// Reads a grid; what is wrong with it stays in `findings`.
  std::optional<Voxels> read(const std::string& name, const std::string& grid = "") {
    findings = {};
    return read_vdb(path(name), name, grid, "/geology", left, findings);
  }
  std::vector<std::string> told() const { return texts(findings.all()); }

  Findings findings;
  std::size_t left = plenty;

 private:
  Folder folder_;
};

float at(const Voxels& voxels, const Voxel& v) {
  return Voxels::Cursor(voxels).at(v[0], v[1], v[2]);
}

TEST_F(Vdb, GivesALevelSetItsDistances) {
  for (const auto packing : {Packing::none, Packing::zip, Packing::blosc}) {
    for (const bool half : {false, true}) {
      VdbForm form{.voxel = 0.5, .packing = packing, .half = half};
      write_ball(path("ball.vdb"), {1, 2, 3}, 20, form);
      const auto voxels = read("ball.vdb");
      ASSERT_TRUE(voxels) << told()[0];
      int near = 0;
      for (std::int32_t i = -50; i < 50; ++i) {
        for (std::int32_t j = -50; j < 50; ++j) {
          const Vec3 p{0.5 * i, 0.5 * j, 3};
          const double d = length(p - Vec3{1, 2, 3}) - 20;
          const float v = at(*voxels, {i, j, 6});
          if (std::abs(d) < 1.4) {
            ASSERT_NEAR(v, d, half ? 2e-3 : 2e-5);
            ++near;
          } else if (d < -1.6) {
            ASSERT_NEAR(v, -1.5, half ? 1e-3 : 0);  // inside of the band
          } else if (d > 1.6) {
            ASSERT_TRUE(std::isnan(v));  // outside of it
          }
        }
      }
      EXPECT_GT(near, 500);
    }
  }
}

TEST_F(Vdb, GivesTheSameContentHoweverItIsPacked) {
  std::vector<Digest> digests;
  for (const auto packing : {Packing::none, Packing::zip, Packing::blosc}) {
    const std::string name = "ball" + std::to_string(digests.size()) + ".vdb";
    write_ball(path(name), {0, 0, 0}, 9, {.name = "n" + name, .packing = packing});
    digests.push_back(read(name)->digest());
  }
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_EQ(digests[0], digests[2]);
  write_ball(path("other.vdb"), {0, 0, 0.01}, 9, {});
  EXPECT_NE(read("other.vdb")->digest(), digests[0]);
}

TEST_F(Vdb, KeepsVoxelsTilesAndTheirPlacement) {
  write_voxels(path("dots.vdb"), {{{-5000, 3, 4}, 1.5F}, {{7, 7, 7}, -2.0F}, {{8, 7, 7}, 0.25F}},
               0.25F, {.voxel = 2, .shift = {10, 0, -4}, .turn = 90});
  const auto dots = read("dots.vdb");
  ASSERT_TRUE(dots) << told()[0];
  EXPECT_EQ(at(*dots, {-5000, 3, 4}), 1.5F);
  EXPECT_EQ(at(*dots, {7, 7, 7}), -2.0F);
  EXPECT_EQ(at(*dots, {8, 7, 7}), 0.25F);  // set, though it is the background's value
  EXPECT_TRUE(std::isnan(at(*dots, {9, 7, 7})));
  EXPECT_EQ(dots->background(), 0.25F);
  tree::VoxelGrid node;
  node.voxels = *dots;
  node.low = 10;
  node.high = 0;
  node.energy = 10;  // 10 - v
  EXPECT_NEAR(tree::value({node, {}}, {10 - 14, 14, 14 - 4}), 10, 1e-5);
  EXPECT_NEAR(tree::value({node, {}}, {10 - 6, -10000, 8 - 4}), 8.5, 1e-5);

  write_box(path("box.vdb"), {-256, -256, -256}, {4359, 255, 255}, 3, {});
  const auto box = read("box.vdb");
  ASSERT_TRUE(box) << told()[0];
  for (const Voxel& v : {Voxel{-256, -256, -256}, Voxel{0, 0, 0}, Voxel{4359, 255, 255}}) {
    EXPECT_EQ(at(*box, v), 3);
  }
  for (const Voxel& v : {Voxel{-257, 0, 0}, Voxel{0, 256, 0}, Voxel{4360, 0, 0}}) {
    EXPECT_TRUE(std::isnan(at(*box, v)));
  }
  EXPECT_LT(plenty - left, 2'000'000u);  // of 10^9 voxels
}

TEST_F(Vdb, TakesTheFirstGridOfFloatsOrTheOneThatIsNamed) {
  write_mixed(path("mixed.vdb"), true);
  const auto first = read("mixed.vdb"), density = read("mixed.vdb", "density");
  ASSERT_TRUE(first && density);
  EXPECT_EQ(*first, *density);
  EXPECT_EQ(at(*density, {1, 2, 3}), 4);
  const auto again = read("mixed.vdb", "again");
  ASSERT_TRUE(again) << told()[0];
  EXPECT_EQ(at(*again, {1, 2, 3}), 4);
  EXPECT_EQ(again->placement().linear[0][0], 2);
}

TEST_F(Vdb, SaysWhichGridsThereAre) {
  write_mixed(path("mixed.vdb"), true);
  EXPECT_FALSE(read("mixed.vdb", "rock"));
  EXPECT_THAT(told(),
              ElementsAre("/geology/grid: \"mixed.vdb\" has no grid \"rock\", but \"mask\" (bool), "
                          "\"velocity\" (vec3s), \"depth\" (double), \"density\" (float), "
                          "\"again\" (float)"));
  EXPECT_FALSE(read("mixed.vdb", "velocity"));
  EXPECT_THAT(told(),
              ElementsAre("/geology/grid: \"mixed.vdb\" has numbers of type vec3s in its grid "
                          "\"velocity\", must be float"));
  write_mixed(path("mixed.vdb"), false);
  EXPECT_FALSE(read("mixed.vdb"));
  EXPECT_THAT(
      told(),
      ElementsAre(HasSubstr("/geology/file: \"mixed.vdb\" has no grid of type float, but")));
}

TEST_F(Vdb, RefusesWhatItCannotUse) {
  write_file(path("text.vdb"), "not a grid at all");
  EXPECT_FALSE(read("text.vdb"));
  EXPECT_THAT(told(), ElementsAre("/geology/file: \"text.vdb\" is no OpenVDB file"));
  write_file(path("empty.vdb"), "");
  EXPECT_FALSE(read("empty.vdb"));
  EXPECT_THAT(told(), ElementsAre("/geology/file: \"empty.vdb\" is no OpenVDB file"));
  write_stream(path("stream.vdb"));
  EXPECT_FALSE(read("stream.vdb"));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("as a stream")));
  write_frustum(path("frustum.vdb"));
  EXPECT_FALSE(read("frustum.vdb"));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("no affine map: \"NonlinearFrustumMap\"")));
  write_voxels(path("nan.vdb"), {{{0, 0, 0}, std::nanf("")}}, 0, {});
  EXPECT_FALSE(read("nan.vdb"));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("no number")));
  write_voxels(path("void.vdb"), {}, 0, {});
  EXPECT_FALSE(read("void.vdb"));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("has no voxel")));
  write_voxels(path("far.vdb"), {{{0, 0, 2'000'000'000}, 1.0F}}, 0, {});
  EXPECT_FALSE(read("far.vdb"));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("beyond index")));
  EXPECT_TRUE(findings.limits.empty());
}

TEST_F(Vdb, HasALimitOnVoxels) {
  write_ball(path("ball.vdb"), {0, 0, 0}, 40, {});
  left = 100'000;
  EXPECT_FALSE(read("ball.vdb"));
  EXPECT_THAT(texts(findings.limits),
              ElementsAre("/geology/file: \"ball.vdb\" has more than the 100000 voxels that the "
                          "grids of a scene may still have"));
  EXPECT_THAT(findings.problems, IsEmpty());
  left = plenty;
  EXPECT_TRUE(read("ball.vdb"));
  EXPECT_LT(left, plenty - 100'000);
}

TEST_F(Vdb, RefusesAFileThatIsCutShortAnywhere) {
  for (const auto packing : {Packing::none, Packing::zip, Packing::blosc}) {
    write_ball(path("ball.vdb"), {0, 0, 0}, 6, {.packing = packing});
    const std::string whole = read_file(path("ball.vdb"), 10'000'000);
    for (std::size_t size = 0; size < whole.size(); size += size < 800 ? 7 : 97 + size / 100) {
      write_file(path("cut.vdb"), whole.substr(0, size));
      ASSERT_FALSE(read("cut.vdb")) << size;
      ASSERT_EQ(findings.problems.size(), 1u);
      ASSERT_EQ(findings.problems[0].where, "/geology/file");
    }
  }
}

TEST_F(Vdb, OutlivesDamageAnywhere) {
  for (const auto packing : {Packing::none, Packing::zip, Packing::blosc}) {
    write_ball(path("ball.vdb"), {0, 0, 0}, 5, {.packing = packing});
    const std::string whole = read_file(path("ball.vdb"), 10'000'000);
    std::mt19937 random(11);
    int refused = 0;
    for (int n = 0; n < 200; ++n) {
      std::string broken = whole;
      for (int k = 0; k < 1 + n % 4; ++k) {
        // Half of the damage where the lengths and places are.
        const auto most = n % 2 == 0 ? std::min<std::size_t>(whole.size(), 900) : whole.size();
        broken[random() % most] = static_cast<char>(n % 3 == 0 ? 0xff : random());
      }
      write_file(path("broken.vdb"), broken);
      left = 2'000'000;
      if (!read("broken.vdb")) {
        ++refused;
        ASSERT_EQ(findings.all().size(), 1u);
      }
    }
    EXPECT_GT(refused, 25);
  }
}

class VoxelScene : public SceneTest {
 protected:
  static json with_geology(const json& grid) {
    auto scene = minimal();
    scene["geology"] = grid;
    return scene;
  }
  static void write(const std::string& name, float value) {
    write_box(folder() / name, {0, 0, 0}, {100, 100, 300}, value,
              {.voxel = 10, .shift = {0, 0, -1000}});
  }
};

TEST_F(VoxelScene, HasAGridAsResistance) {
  write("rock.vdb", 0.75F);
  const auto scene = opened(with_geology({{"type", "grid"}, {"file", "rock.vdb"}}));
  EXPECT_EQ(tree::value(*scene.ground.geology, {500, 500, 20}), 0.75);
  EXPECT_EQ(tree::value(*scene.ground.geology, {-500, 500, 20}), 0);
}

TEST_F(VoxelScene, DependsOnAGridsContentAndNotOnItsName) {
  write("one.vdb", 0.5F);
  write("two.vdb", 0.5F);
  write("three.vdb", 0.25F);
  const auto geology = [](const std::string& name, const std::string& grid) {
    const auto scene = opened(with_geology({{"type", "grid"}, {"file", name}, {"grid", grid}}));
    return tree::to_json(scene.ground).dump();
  };
  EXPECT_EQ(geology("one.vdb", ""), geology("two.vdb", "density"));
  EXPECT_NE(geology("one.vdb", ""), geology("three.vdb", ""));
  EXPECT_THAT(geology("one.vdb", ""), testing::Not(HasSubstr("vdb")));
}

TEST_F(VoxelScene, TellsEveryPlaceWhereAGridIsWrong) {
  write("rock.vdb", 1);
  auto scene =
      with_geology({{"type", "blend"},
                    {"children",
                     {{{"type", "grid"}, {"file", "nowhere.vdb"}},
                      {{"type", "grid"}, {"file", "dem.tif"}},
                      {{"type", "grid"}, {"file", "rock.vdb"}, {"grid", "softness"}},
                      {{"type", "grid"}, {"file", "rock.vdb"}, {"low", 2}, {"high", 2}}}}});
  scene["define"]["unused"] = {{"type", "grid"}, {"file", "nowhere.vdb"}};
  EXPECT_THAT(
      texts(problems(scene)),
      testing::UnorderedElementsAre("/geology/children/0/file: no file \"nowhere.vdb\"",
                                    "/geology/children/1/file: \"dem.tif\" is no OpenVDB file",
                                    "/geology/children/2/grid: \"rock.vdb\" has no grid "
                                    "\"softness\", but \"density\" (float)",
                                    HasSubstr("/geology/children/3/high: must differ"),
                                    "/define/unused/file: no file \"nowhere.vdb\""));
  const auto missing = with_geology({{"type", "grid"}, {"file", "nowhere.vdb"}});
  try {
    opened(missing);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::not_found);
  }
}

TEST_F(VoxelScene, ReadsNoGridOutsideTheFoldersItMay) {
  const Folder elsewhere;
  write_box(elsewhere / "secret.vdb", {0, 0, 0}, {9, 9, 9}, 1, {});
  std::filesystem::create_symlink(elsewhere / "secret.vdb", folder() / "link.vdb");
  const Sources confined{folder().path(), {folder().path()}};
  for (const std::string& name : {(elsewhere / "secret.vdb").string(), std::string("link.vdb")}) {
    EXPECT_THAT(texts(check(with_geology({{"type", "grid"}, {"file", name}}), confined)),
                ElementsAre(HasSubstr("/geology/file: \"" + name + "\" lies outside")));
  }
}

TEST_F(VoxelScene, CountsAGridOnceHoweverOftenItIsUsed) {
  // Five like this one would not fit.
  write_ball(folder() / "big.vdb", {0, 0, 0}, 500, {.voxel = 2, .packing = Packing::zip});
  json children = json::array();
  for (int i = 0; i < 20; ++i)
    children.push_back({{"type", "grid"}, {"file", "big.vdb"}, {"energy", 0.1 + i}});
  EXPECT_THAT(texts(problems(with_geology({{"type", "blend"}, {"children", children}}))),
              IsEmpty());
}

}  // namespace
}  // namespace hoodoo::scene
