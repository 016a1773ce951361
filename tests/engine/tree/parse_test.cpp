#include "engine/tree/parse.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace hoodoo::tree {
namespace {

using nlohmann::json;

struct Parsed {
  std::optional<Node> node;
  std::vector<Problem> problems, warnings;
  /// "where: what" of the first problem.
  std::string first() const {
    return problems.empty() ? "" : problems[0].where + ": " + problems[0].what;
  }
};

Parsed parse(const char* text, const json& define = json::object(),
             Family family = Family::terrain) {
  Context context;
  for (const auto& [name, value] : define.items()) {
    context.definitions[name] = {&value, "/define/" + name};
  }
  Parsed parsed;
  parsed.node = parse_node(json::parse(text), "/tree", family, context, parsed.problems);
  parsed.warnings = context.warnings;
  return parsed;
}

TEST(ParseNode, ReadsPointsInAllThreeForms) {
  const auto p = parse(R"({"type": "segment", "radius": 2,
    "from": {"xy": [3, 4], "ground": -1}, "to": {"uv": [0.5, 1], "ground": 2}})");
  ASSERT_TRUE(p.problems.empty()) << p.first();
  const auto& s = std::get<Segment>(p.node->value);
  EXPECT_EQ(s.from, Point(Point::Form::ground_xy, {3, 4, -1}));
  EXPECT_EQ(s.to, Point(Point::Form::ground_uv, {0.5, 1, 2}));
  EXPECT_EQ(std::get<PointNode>(
                parse(R"({"type": "point", "center": [1, 2, 3], "radius": 1})").node->value)
                .center,
            Point(Vec3{1, 2, 3}));
}

TEST(ParseNode, ReadsListsOfBalls) {
  const auto p = parse(R"({"type": "points", "balls": [[1, 2, 3, 4], [5, 6, 7, 8, -0.5]]})");
  ASSERT_TRUE(p.problems.empty()) << p.first();
  const std::vector<Ball> expected{{{1, 2, 3}, 4, 1}, {{5, 6, 7}, 8, -0.5F}};
  EXPECT_EQ(std::get<PointSet>(p.node->value).balls.list(), expected);
  EXPECT_EQ(parse(R"({"type": "points", "balls": [[1, 2, 3, 0]]})").first(),
            "/tree/balls/0/3: must be in (0, 100000] m, got 0");
  EXPECT_EQ(parse(R"({"type": "spheres", "balls": [[1, 2, 3]]})").first(),
            "/tree/balls/0: must be [x, y, z, radius] or [x, y, z, radius, energy], got an array");
  EXPECT_EQ(parse(R"({"type": "spheres", "balls": []})").first(),
            "/tree/balls: must be an array of 1 to 1000000 balls, got 0");
}

TEST(ParseNode, ReportsEveryProblemWithPointerValueUnitAndRange) {
  const auto p = parse(R"({"type": "union", "children": [
      {"type": "sphere", "center": [0, 0], "radius": -1},
      {"type": "sphere", "centre": [0, 0, 0], "radius": 1, "falloff": 0},
      {"type": "spere"}]})");
  std::vector<std::string> all;
  for (const auto& problem : p.problems) all.push_back(problem.where + ": " + problem.what);
  const std::vector<std::string> expected{
      "/tree/children/0/center: must be [x, y, z] or an object with \"ground\", got an array",
      "/tree/children/0/radius: must be in (0, 100000] m, got -1",
      "/tree/children/1/center: is missing",
      "/tree/children/1/falloff: must be in (0, 100000] m, got 0",
      "/tree/children/1/centre: is not a known key, did you mean \"center\"?",
      "/tree/children/2/type: names no node type: \"spere\", did you mean \"sphere\"?"};
  EXPECT_EQ(all, expected);
}

TEST(ParseNode, RefusesWhatDoesNotFitTogether) {
  EXPECT_EQ(parse(R"({"type": "cone", "base": [1, 2, 3], "tip": [1, 2, 3], "radius": 1})").first(),
            "/tree/tip: must not be where the base is");
  EXPECT_EQ(parse(R"({"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 1, 200]})").first(),
            "/tree/radii: must not differ by more than a factor of 100");
  EXPECT_EQ(parse(R"({"type": "rotate", "axis": [0, 0, 0], "angle": 9,
                      "child": {"type": "blend"}})")
                .first(),
            "/tree/axis: must not be [0, 0, 0]: it has no direction");
  EXPECT_EQ(parse(R"({"type": "point", "center": [0, 0, 0], "radius": 1,
                      "turbulence": {"amplitude": 3}})")
                .first(),
            "/tree/turbulence/amplitude: must be below radius / 0.4542 = 2.20166 m, got 3");
}

TEST(ParseNode, KeepsGeologyOutOfTerrainTrees) {
  const char* strata = R"({"type": "strata", "wavelength": 3})";
  EXPECT_EQ(parse(strata).first(), "/tree/type: strata belongs into \"geology\" only");
  EXPECT_TRUE(parse(strata, {}, Family::geology).problems.empty());
}

TEST(ParseNode, KeepsDistancesAndFieldsApart) {
  EXPECT_TRUE(parse(R"({"type": "from_distance", "child": {"type": "offset", "by": 1, "child":
      {"type": "translate", "by": [1, 2, 3], "child":
        {"type": "sphere", "center": [0, 0, 0], "radius": 2}}}})")
                  .problems.empty());
  EXPECT_EQ(parse(R"({"type": "from_distance", "child":
                      {"type": "point", "center": [0, 0, 0], "radius": 2}})")
                .first(),
            "/tree/child/type: point belongs into a field, not into a distance tree");
  EXPECT_EQ(parse(R"({"type": "offset", "by": 1, "child": {}})").first(),
            "/tree/type: offset belongs into a distance tree, below \"from_distance\"");
}

TEST(ParseNode, ReadsEachSlotInItsOwnFamily) {
  const auto p = parse(R"({"type": "erosion",
      "resistance": {"type": "strata", "wavelength": 9},
      "control": {"type": "strata", "wavelength": 9}})");
  ASSERT_EQ(p.problems.size(), 1u);
  EXPECT_EQ(p.first(), "/tree/control/type: strata belongs into \"geology\" only");
}

TEST(ParseNode, SaysWhatIsWrongWithAFormulaAPlacementOrAnOutline) {
  EXPECT_EQ(
      parse(R"({"type": "expression", "formula": "x + dept", "parameters": {"depth": 3}})").first(),
      "/tree/formula: column 5: \"dept\" is neither a coordinate, a parameter nor a function, "
      "did you mean \"depth\"?");
  EXPECT_EQ(parse(R"({"type": "expression", "formula": "1", "parameters": {"x": 3}})").first(),
            "/tree/parameters: \"x\" is no name for a parameter: letters, digits and _, a letter "
            "first, at most 32, and no other meaning");
  EXPECT_EQ(parse(R"({"type": "repeat", "placements": [{"at": [0, 0, 0]}, {"scale": 0}],
                      "child": {"type": "blend", "children": []}})")
                .problems.size(),
            2u);
  EXPECT_EQ(parse(R"({"type": "prism", "outline": [[0, 0], [1, 0], [2, 0]],
                      "bottom": 0, "top": 1})")
                .first(),
            "/tree/outline: encloses no area");
}

TEST(ParseNode, ExpandsInstances) {
  const json define = {
      {"pair", {{"type", "union"}, {"children", {{{"use", "ball"}}, {{"use", "ball"}}}}}},
      {"ball", {{"type", "sphere"}, {"center", {0, 0, 0}}, {"radius", 3}, {"falloff", 2}}}};
  const auto p =
      parse(R"({"type": "translate", "by": [1, 2, 3], "child": {"use": "pair"}})", define);
  ASSERT_TRUE(p.problems.empty()) << p.first();
  EXPECT_EQ(count(*p.node), 4u);
  EXPECT_EQ(parse(R"({"use": "bal"})", define).first(),
            "/tree/use: names \"bal\", which \"define\" does not hold, did you mean \"ball\"?");
}

TEST(ParseNode, ReportsTheProblemsOfADefinitionOnce) {
  const json define = {{"ball", {{"type", "sphere"}, {"center", {0, 0, 0}}, {"radius", 0}}}};
  const auto p =
      parse(R"({"type": "union", "children": [{"use": "ball"}, {"use": "ball"}]})", define);
  ASSERT_EQ(p.problems.size(), 1u);
  EXPECT_EQ(p.first(), "/define/ball/radius: must be in (0, 100000] m, got 0");
}

TEST(ParseNode, NamesTheChainOfACycle) {
  const json define = {{"a", {{"type", "translate"}, {"by", {0, 0, 1}}, {"child", {{"use", "b"}}}}},
                       {"b", {{"type", "union"}, {"children", {{{"use", "a"}}}}}}};
  const auto p = parse(R"({"use": "a"})", define);
  ASSERT_EQ(p.problems.size(), 1u);
  EXPECT_EQ(p.first(), "/define/b/children/0/use: is a cycle: a -> b -> a");
}

TEST(ParseNode, StopsAtTheLimitsOfDepthAndNumber) {
  // Each name holds the one below ten times: 10^12 nodes when expanded.
  json define;
  define["n0"] = {{"type", "point"}, {"center", {0, 0, 0}}, {"radius", 1}};
  for (int i = 1; i <= 12; ++i) {
    json ten = json::array();
    for (int k = 0; k < 10; ++k) ten.push_back({{"use", "n" + std::to_string(i - 1)}});
    define["n" + std::to_string(i)] = {{"type", "blend"}, {"children", ten}};
  }
  const auto many = parse(R"({"use": "n12"})", define);
  ASSERT_EQ(many.problems.size(), 1u);
  EXPECT_NE(many.first().find("one node too many"), std::string::npos) << many.first();

  json deep = {{"type", "blend"}};
  for (int i = 0; i < 100; ++i) {
    deep = {{"type", "translate"}, {"by", {0, 0, 1}}, {"child", deep}};
  }
  const auto p = parse(deep.dump().c_str());
  ASSERT_EQ(p.problems.size(), 1u);
  EXPECT_NE(p.first().find("nested deeper than 64"), std::string::npos) << p.first();
}

TEST(ParseNode, WarnsOfAFalloffThatNeverReachesItsPeak) {
  EXPECT_TRUE(parse(R"({"type": "sphere", "center": [0,0,0], "radius": 2, "falloff": 4.4})")
                  .warnings.empty());
  const auto p = parse(R"({"type": "sphere", "center": [0,0,0], "radius": 2, "falloff": 5})");
  EXPECT_TRUE(p.problems.empty());
  ASSERT_EQ(p.warnings.size(), 1u);
  EXPECT_EQ(p.warnings[0].where, "/tree/falloff");
}

TEST(ToJson, StatesEveryValue) {
  const auto node = parse(R"({"type": "sphere", "center": [1, 2, 3], "radius": 2})").node;
  EXPECT_EQ(to_json(*node), json::parse(R"({"type": "sphere", "center": [1, 2, 3], "radius": 2,
      "falloff": 4, "energy": 1,
      "turbulence": {"amplitude": 0, "wavelength": 10, "octaves": 3, "seed": 0}})"));
}

TEST(ForEachPoint, FindsThemAllInTheirOrder) {
  auto node = parse(R"({"type": "rotate", "angle": 10, "pivot": [1, 0, 0], "child":
    {"type": "polyline", "points": [[2, 0, 0], [3, 0, 0]], "radius": 1}})")
                  .node;
  double next = 1;
  for_each_point(*node, [&](Point& p) { EXPECT_EQ(p.value.x, next++); });
  EXPECT_EQ(next, 4);
}

TEST(NodeSchema, HoldsEveryTypeOfAFamilyOnce) {
  const json schema = node_schema();
  const auto types = [&](const char* family) {
    return schema[family]["else"]["properties"]["type"]["enum"].size();
  };
  // All but four that are geology only and three that are distances only.
  EXPECT_EQ(types("terrain_node"), std::variant_size_v<AnyNode> - 4 - 3);
  EXPECT_EQ(types("any_node"), std::variant_size_v<AnyNode>);
  EXPECT_EQ(schema["node.strata"]["properties"]["type"]["const"], "strata");
  EXPECT_EQ(schema["node.union"]["properties"]["children"]["items"]["$ref"],
            "#/$defs/terrain_node");
  EXPECT_EQ(schema["geology.node.blend"]["properties"]["children"]["items"]["$ref"],
            "#/$defs/geology_node");
  EXPECT_EQ(schema["node.from_distance"]["properties"]["child"]["$ref"], "#/$defs/distance_node");
  EXPECT_EQ(schema["any.node.rotate"]["properties"]["child"]["$ref"], "#/$defs/any_node");
  EXPECT_EQ(schema["distance.node.rotate"]["properties"]["child"]["$ref"], "#/$defs/distance_node");
  // Every reference leads somewhere.
  const std::string text = schema.dump(), prefix = "#/$defs/";
  for (auto at = text.find(prefix); at != text.npos; at = text.find(prefix, at + 1)) {
    const auto from = at + prefix.size();
    EXPECT_TRUE(schema.contains(text.substr(from, text.find('"', from) - from)));
  }
}

}  // namespace
}  // namespace hoodoo::tree
