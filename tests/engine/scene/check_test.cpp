#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>

#include "engine/base/file.hpp"
#include "engine/base/json.hpp"
#include "tests/engine/scene/fixture.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Check : public SceneTest {
 protected:
  /// The smallest scene with `patch` merged in.
  static json with(const char* patch) {
    auto scene = minimal();
    scene.merge_patch(json::parse(patch));
    return scene;
  }
  static std::vector<std::string> of(const char* patch) { return texts(problems(with(patch))); }
  static Fault fault(const json& scene) {
    try {
      opened(scene);
    } catch (const Error& error) {
      return error.fault;
    }
    ADD_FAILURE() << "was accepted";
    return Fault::internal;
  }
};

TEST_F(Check, FindsNothingWrongWithTheSmallestScene) {
  EXPECT_THAT(texts(problems(minimal())), IsEmpty());
}

TEST_F(Check, BindsMaterialsToStrataThatAreThere) {
  const char* const geology =
      R"("geology": {"type": "blend", "children": [{"type": "strata", "wavelength": 9},
    {"type": "stratum", "name": "coal", "child": {"type": "plane", "point": [0, 0, 9]}}]})";
  const auto stated = [&](const char* materials) {
    return of(fmt::format("{{{}, \"materials\": {}}}", geology, materials).c_str());
  };
  EXPECT_THAT(stated(R"([{"name": "rock"}, {"name": "coal", "stratum": "coal"}])"), IsEmpty());
  EXPECT_THAT(
      stated(R"([{"name": "rock"}, {"name": "coal", "stratum": "coals"}])"),
      ElementsAre(AllOf(HasSubstr("/materials/1/stratum"), HasSubstr("did you mean \"coal\""))));
  EXPECT_THAT(stated(R"([{"name": "coal", "stratum": "coal"}])"),
              ElementsAre(AllOf(HasSubstr("/materials"), HasSubstr("no \"stratum\""))));
  EXPECT_THAT(of(R"({"materials": [{"name": "a"}, {"name": "b", "stratum": "coal"}]})"),
              ElementsAre(HasSubstr("/materials/1/stratum")));
}

TEST_F(Check, ReportsEveryProblemAtOnce) {
  const auto scene = with(R"({
    "hoodoo": 2,
    "seed": -1,
    "materials": [{"name": "a", "color": "red"}, {"name": "a", "resistance": [0.5, 2]}],
    "terrains": [{"id": "land", "dem": "none.tif", "falloff": 0}],
    "geology": {"type": "strata", "wavelength": -3},
    "operations": [
      {"op": "union", "tree": {"type": "sphere", "center": [0, 0, 0], "radius": "big"}},
      {"op": "unite", "tree": {"type": "sphere", "center": [0, 0], "radius": 1}},
      {"type": "tunel", "path": []},
      {"type": "tunnel", "path": [[0, 0, 0], [1, 0, 0]], "radius": 2, "material": "b"},
      {"op": "difference"}
    ],
    "bake": {"spacing": 0, "tile_cells": 100, "extent": {"min": [0, 0], "max": [0, 5]}}
  })");
  EXPECT_THAT(
      places_of(problems(scene)),
      ElementsAre("/bake/extent", "/bake/spacing", "/geology/wavelength", "/hoodoo",
                  "/materials/0/color", "/materials/1/name", "/materials/1/resistance/1",
                  "/operations/0/tree/radius", "/operations/1/op", "/operations/1/tree/center",
                  "/operations/2/type", "/operations/3/material", "/operations/4/tree", "/seed",
                  "/terrains/0/dem", "/terrains/0/falloff"));
}

TEST_F(Check, SaysValueUnitAndRange) {
  EXPECT_THAT(of(R"({"bake": {"spacing": 0}})"),
              ElementsAre(AllOf(HasSubstr("/bake/spacing: "), HasSubstr("[0.001, 100000] m"),
                                HasSubstr("0"))));
}

TEST_F(Check, SuggestsTheNearestKey) {
  EXPECT_THAT(of(R"({"opertions": []})"),
              ElementsAre(AllOf(HasSubstr("/opertions: "), HasSubstr("\"operations\""))));
  EXPECT_THAT(of(R"({"terrains": [{"dem": "dem.tif", "nodatta": "hole"}]})"),
              ElementsAre(AllOf(HasSubstr("/terrains/0/nodatta: "), HasSubstr("\"nodata\""))));
  EXPECT_THAT(of(R"({"operations": [{"type": "tunel"}]})"),
              ElementsAre(AllOf(HasSubstr("/operations/0/type: "), HasSubstr("\"tunnel\""))));
  EXPECT_THAT(of(R"({"operations": [{"type": "sphere", "centre": [0, 0, 0], "radius": 1}]})"),
              ElementsAre(HasSubstr("/operations/0/center: is missing"),
                          AllOf(HasSubstr("/operations/0/centre: "), HasSubstr("\"center\""))));
  EXPECT_THAT(of(R"({"base": {"closed": 10}})"), ElementsAre(HasSubstr("/base: ")));
}

TEST_F(Check, SuggestsTheNearestMaterial) {
  EXPECT_THAT(of(R"({"materials": [{"name": "limestone"}, {"name": "shale"}], "operations": [
                  {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "limstone"}]})"),
              ElementsAre(AllOf(HasSubstr("/operations/0/material: "), HasSubstr("limestone"))));
}

TEST_F(Check, WantsATerrain) {
  EXPECT_THAT(of(R"({"terrains": null})"), ElementsAre(HasSubstr("/terrains: ")));
  EXPECT_THAT(of(R"({"terrains": []})"), ElementsAre(HasSubstr("/terrains: ")));
  EXPECT_THAT(of(R"({"terrains": [{}]})"), ElementsAre(HasSubstr("/terrains/0/dem: is missing")));
  EXPECT_THAT(of(R"({"terrains": [7]})"), ElementsAre(HasSubstr("/terrains/0: ")));
}

TEST_F(Check, NamesTheCycleOfUse) {
  const auto scene = with(R"({"define": {
      "a": {"type": "union", "children": [{"use": "b"}]},
      "b": {"type": "translate", "by": [1, 2, 3], "child": {"use": "a"}}},
    "operations": [{"op": "union", "tree": {"use": "a"}}]})");
  const auto found = texts(problems(scene));
  ASSERT_THAT(found, testing::Not(IsEmpty()));
  EXPECT_THAT(found[0], AllOf(HasSubstr("a"), HasSubstr("b"), HasSubstr("cycle")));
  EXPECT_EQ(fault(scene), Fault::bad_input);
}

TEST_F(Check, ChecksDefinitionsThatNothingUses) {
  EXPECT_THAT(of(R"({"define": {"a/b": {"type": "sphere", "center": [0, 0, 0], "radius": -1}}})"),
              ElementsAre(HasSubstr("/define/a~1b/radius: ")));
  EXPECT_THAT(of(R"({"define": {"layers": {"type": "strata", "wavelength": 5}}})"), IsEmpty());
}

TEST_F(Check, RefusesTheSameIdTwice) {
  EXPECT_THAT(of(R"({"operations": [
      {"id": "a", "type": "sphere", "center": [0, 0, 0], "radius": 1},
      {"id": "a", "type": "sphere", "center": [0, 0, 0], "radius": 1}]})"),
              ElementsAre("/operations/1/id: is that of /operations/0 too"));
  EXPECT_THAT(of(R"({"terrains": [{"id": "a", "dem": "dem.tif"}, {"id": "a", "dem": "dem.tif"}]})"),
              ElementsAre("/terrains/1/id: is that of /terrains/0 too"));
}

TEST_F(Check, KnowsAMissingFileFromAWrongScene) {
  const auto missing = with(R"({"terrains": [{"id": "land", "dem": "none.tif"}]})");
  EXPECT_THAT(texts(problems(missing)), ElementsAre("/terrains/0/dem: no file \"none.tif\""));
  EXPECT_EQ(fault(missing), Fault::not_found);
  EXPECT_EQ(fault(with(R"({"name": 3, "terrains": [{"dem": "none.tif"}]})")), Fault::bad_input);
}

TEST_F(Check, SaysWhichFileIsNoDem) {
  write_file(folder() / "text.tif", "not a picture");
  const auto scene = with(R"({"terrains": [{"dem": "text.tif"}]})");
  const auto found = problems(scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].where, "/terrains/0/dem");
  EXPECT_THAT(found[0].what, HasSubstr("\"text.tif\""));
  EXPECT_THAT(found[0].what, testing::Not(HasSubstr(folder().path().string())));
}

TEST_F(Check, RefusesMoreCellsThanCanBeBaked) {
  SampleDem wide{64, 1600, 1};  // 102.4 km
  write_sample_dem(folder() / "wide.tif", wide);
  auto scene = with(R"({"terrains": [{"dem": "wide.tif"}], "bake": {"spacing": 0.001}})");
  EXPECT_THAT(texts(problems(scene)),
              ElementsAre(AllOf(HasSubstr("/bake/spacing: "), HasSubstr("limit"))));
  EXPECT_EQ(fault(scene), Fault::limit);
  // A small part of it is fine.
  scene["bake"]["extent"] = {{"min", {0, 0}}, {"max", {1, 1}}};
  EXPECT_THAT(texts(problems(scene)), IsEmpty());
}

TEST_F(Check, RefusesMoreNodesThanTheLimit) {
  // 40 definitions, each using the next ten times.
  auto scene = minimal();
  for (int i = 0; i < 40; ++i) {
    json children = json::array();
    for (int k = 0; k < 10; ++k) children.push_back({{"use", "d" + std::to_string(i + 1)}});
    scene["define"]["d" + std::to_string(i)] = {{"type", "union"}, {"children", children}};
  }
  scene["define"]["d40"] = {{"type", "sphere"}, {"center", {0, 0, 0}}, {"radius", 1}};
  scene["operations"] = {{{"op", "union"}, {"tree", {{"use", "d0"}}}}};
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(fault(scene), Fault::limit);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST_F(Check, StopsCountingProblemsAtSomePoint) {
  auto scene = minimal();
  for (int i = 0; i < 20'000; ++i) scene["operations"].push_back(7);
  const auto count = problems(scene).size();
  EXPECT_GT(count, 100U);
  EXPECT_LT(count, 5'000U);
}

TEST_F(Check, TakesAnyJsonWithoutACrash) {
  for (const char* text : {"null", "[]", "7", "\"scene\"", "{}", R"({"hoodoo": 1})",
                           R"({"terrains": {"dem": 1}, "operations": {"a": []}, "define": [1]})",
                           R"({"operations": [[], null, {}, {"type": []}, {"op": {}, "tree": 7}]})",
                           R"({"geology": {"use": 7}, "bake": [], "materials": [[]]})"}) {
    EXPECT_FALSE(problems(json::parse(text)).empty()) << text;
  }
}

TEST_F(Check, TellsOddities) {
  std::vector<Problem> warnings;
  const auto scene = with(R"({"operations": [{"op": "union", "tree":
      {"type": "sphere", "center": [0, 0, 0], "radius": 2, "falloff": 100}}]})");
  EXPECT_THAT(texts(check(scene, sources(), &warnings)), IsEmpty());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0].where, HasSubstr("/operations/0/tree"));
}

TEST_F(Check, RefusesHostileTextQuickly) {
  const Folder hostile;
  {
    std::ofstream nested(hostile / "nested.json");
    for (int i = 0; i < 1'000'000; ++i) nested << '[';
    std::ofstream(hostile / "long.json") << "\"";
  }
  // Two gigabytes that take no room on disk.
  std::filesystem::resize_file(hostile / "long.json", std::uintmax_t{2} << 30);
  for (const char* name : {"nested.json", "long.json"}) {
    const auto start = std::chrono::steady_clock::now();
    try {
      read(hostile / name);
      ADD_FAILURE() << name << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.fault, Fault::limit) << name;
      EXPECT_THAT(error.problems[0].where, HasSubstr(name));
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1)) << name;
  }
  EXPECT_THROW(read(hostile / "none.json"), Error);
}

}  // namespace
}  // namespace hoodoo::scene
