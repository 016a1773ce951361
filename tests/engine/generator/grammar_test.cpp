#include "engine/generator/grammar.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/random.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::generator {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// "where: what" of the problems of a grammar.
std::vector<std::string> problems_of(const json& grammar) {
  std::vector<Problem> problems;
  tree::Context context;
  read_grammar(
      grammar, "/g",
      [&](const json& node, const std::string& at) {
        return tree::parse_node(node, at, tree::Family::terrain, context, problems);
      },
      problems);
  std::vector<std::string> texts;
  for (const auto& problem : problems) texts.push_back(problem.where + ": " + problem.what);
  return texts;
}

Grammar grammar_of(const json& stated) {
  std::vector<Problem> problems;
  tree::Context context;
  auto made = read_grammar(
      stated, "/g",
      [&](const json& node, const std::string& at) {
        return tree::parse_node(node, at, tree::Family::terrain, context, problems);
      },
      problems);
  EXPECT_THAT(problems_of(stated), ElementsAre());
  return made ? *std::move(made) : Grammar();
}

double half(const Vec3&) { return 0.5; }

/// Balls on top of each other until one is less than 2 m wide.
json tower() {
  return json::parse(R"json({
    "axiom": "A",
    "parameters": {"shrink": 0.5},
    "rules": [
      {"symbol": "A", "to": ["ball", {"symbol": "B", "move": [0, 0, "2*s"], "scale": "shrink"}]},
      {"symbol": "B", "probability": "clamp(s - 1, 0, 1)",
       "to": [{"terminal": "ball", "move": ["n", "h", 0]},
              {"symbol": "B", "move": [1, 0, "s"], "scale": 0.5,
               "rotate": {"angle": 90}}]},
      {"symbol": "B", "to": ["cap"]}],
    "terminals": {
      "ball": {"type": "sphere", "center": [0, 0, 0], "radius": "s*(0.5+rho)", "falloff": "s"},
      "cap": {"type": "cone", "base": [0, 0, 0], "tip": [2, 0, "s+slope"], "radius": "s"}}})json");
}

void expect_near(const Vec3& a, const Vec3& b) {
  EXPECT_NEAR(a.x, b.x, 1e-9);
  EXPECT_NEAR(a.y, b.y, 1e-9);
  EXPECT_NEAR(a.z, b.z, 1e-9);
}

TEST(Grammar, DerivesTheTerminalsThatItsRulesSay) {
  const auto made = derive(grammar_of(tower()), {{10, 20, 30}, 8, 0.25, 1, {}}, 64, half);
  // A: s = 8 at z = 30; B: s = 4 at z = 46; B: s = 2 at z = 50, turned; B: s = 1 at z = 52.
  ASSERT_EQ(made.parts.size(), 4U);
  EXPECT_EQ(made.symbols, 4U);
  const auto& first = std::get<tree::Sphere>(made.parts[0].value);
  expect_near(first.center.value, {10, 20, 30});
  EXPECT_DOUBLE_EQ(first.radius, 8);
  EXPECT_DOUBLE_EQ(first.falloff, 8);
  const auto& second = std::get<tree::Sphere>(made.parts[1].value);
  expect_near(second.center.value, {10 + 1, 20 + 16, 46});
  EXPECT_DOUBLE_EQ(second.radius, 4);
  const auto& third = std::get<tree::Sphere>(made.parts[2].value);
  // One further along x; from there the frame is turned: its x is the scene's y, its y is -x.
  expect_near(third.center.value, {11 - 20, 20 + 2, 50});
  EXPECT_DOUBLE_EQ(third.radius, 2);
  const auto& cap = std::get<tree::Cone>(made.parts[3].value);
  expect_near(cap.base.value, {11, 21, 52});
  expect_near(cap.tip.value, {11 - 2, 21, 52 + 1 + 0.25});
  EXPECT_DOUBLE_EQ(cap.radius, 1);
}

TEST(Grammar, MakesThinnerPartsOfWeakerRock) {
  const auto grammar = grammar_of(tower());
  const auto at_rho = [&](double rho) {
    const auto made = derive(grammar, {{0, 0, 0}, 8, 0, 1, {}}, 64,
                             [=](const Vec3& p) { return p.z < 8 ? 1.0 : rho; });
    return std::pair(std::get<tree::Sphere>(made.parts[0].value).radius,
                     std::get<tree::Sphere>(made.parts[1].value).radius);
  };
  EXPECT_EQ(at_rho(0.1), std::pair(12.0, 4 * 0.6));
  EXPECT_EQ(at_rho(0.9), std::pair(12.0, 4 * 1.4));
}

TEST(Grammar, TakesRulesWithTheirProbability) {
  const auto grammar = grammar_of(json::parse(R"json({
    "axiom": "A",
    "rules": [{"symbol": "A", "probability": "0.6*rho", "to": ["a"]},
              {"symbol": "A", "probability": 0.25, "to": ["a", "a"]},
              {"symbol": "A", "to": ["a", "a", "a"]}],
    "terminals": {"a": {"type": "sphere", "center": [0, 0, 0], "radius": 1}}})json"));
  constexpr int axioms = 20'000;
  std::array<int, 4> taken{};
  for (int i = 0; i < axioms; ++i) {
    const auto key = random_bits(7, i);
    ++taken[derive(grammar, {{0, 0, 0}, 1, 0, key, {}}, 64, half).parts.size()];
  }
  for (const auto& [parts, p] : {std::pair<std::size_t, double>{1, 0.3}, {2, 0.25}, {3, 0.45}}) {
    EXPECT_NEAR(taken[parts], axioms * p, 3 * std::sqrt(axioms * p * (1 - p))) << parts;
  }
}

TEST(Grammar, DrawsEveryRandomNumberAnew) {
  const auto grammar = grammar_of(json::parse(R"json({
    "axiom": "A", "rules": [{"symbol": "A", "to": ["a", "a"]}],
    "terminals": {"a": {"type": "sphere", "center": ["u", "u", 0], "radius": "1 + u - u"}}})json"));
  const auto made = derive(grammar, {{0, 0, 0}, 1, 0, 5, {}}, 64, half);
  const auto& a = std::get<tree::Sphere>(made.parts[0].value);
  const auto& b = std::get<tree::Sphere>(made.parts[1].value);
  EXPECT_NE(a.center.value.x, a.center.value.y);
  EXPECT_NE(a.center.value.x, b.center.value.x);
  EXPECT_EQ(a.radius, 1);  // one formula, one number
  EXPECT_EQ(derive(grammar, {{0, 0, 0}, 1, 0, 5, {}}, 64, half).parts, made.parts);
  EXPECT_NE(derive(grammar, {{0, 0, 0}, 1, 0, 6, {}}, 64, half).parts, made.parts);
}

TEST(Grammar, TurnsWhatHasAxesByNodesAroundIt) {
  const auto grammar = grammar_of(json::parse(R"json({
    "axiom": "A",
    "rules": [{"symbol": "A", "to": [{"terminal": "slab", "move": [0, 0, 2],
                                      "rotate": {"axis": [1, 0, 0], "angle": 30}}]}],
    "terminals": {"slab": {"type": "box", "center": [0, 0, 1], "size": ["4*s", 4, 1]}}})json"));
  const auto made = derive(grammar, {{5, 6, 7}, 2, 0, 5, {}}, 64, half);
  ASSERT_EQ(made.parts.size(), 1U);
  const auto& moved = std::get<tree::Translate>(made.parts[0].value);
  EXPECT_EQ(moved.by, (Vec3{5, 6, 9}));
  const auto& turned = made.parts[0].children[0];
  EXPECT_EQ(std::get<tree::Rotate>(turned.value).angle, 30);
  EXPECT_EQ(std::get<tree::BoxNode>(turned.children[0].value).size, (Vec3{8, 4, 1}));
}

TEST(Grammar, EndsWhereItIsTooDeepOrTooLarge) {
  const auto endless = grammar_of(json::parse(R"json({
    "axiom": "A",
    "rules": [{"symbol": "A", "to": ["a", "A"]}, {"symbol": "A", "probability": 0, "to": []},
              {"symbol": "A", "probability": 1, "to": ["a", "A", "A"]}],
    "terminals": {"a": {"type": "sphere", "center": [0, 0, 0], "radius": "1 - n/4"}}})json"));
  const auto deep = derive(endless, {{0, 0, 0}, 1, 0, 5, {}}, 8, half);
  EXPECT_EQ(deep.symbols, 255U);
  EXPECT_EQ(deep.too_deep, 256U);
  EXPECT_EQ(deep.parts.size(), 7U);  // n = 1, 2, 3: 1 + 2 + 4; from n = 4 on without a size
  EXPECT_EQ(deep.without_size, 248U);
  const auto large = derive(endless, {{0, 0, 0}, 1, 0, 5, {}}, 40, half);
  EXPECT_EQ(large.symbols, most_symbols);
  EXPECT_GT(large.too_many, 0U);
}

TEST(Grammar, NamesWhatIsWrongWithIt) {
  auto stated = tower();
  stated["rules"][0]["to"][1]["symbol"] = "Q";
  EXPECT_THAT(problems_of(stated), ElementsAre(HasSubstr("/g/rules/0/to/1/symbol: names \"Q\"")));
  stated = tower();
  stated["rules"][0]["to"][0] = "bal";
  EXPECT_THAT(problems_of(stated),
              ElementsAre(AllOf(StartsWith("/g/rules/0/to/0: "), HasSubstr("\"ball\"?"))));
  stated = tower();
  stated["axiom"] = "X";
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/axiom: names \"X\", which no rule")));
  stated = tower();
  stated["rules"][0]["to"][1]["scale"] = "shrnk";
  EXPECT_THAT(problems_of(stated), ElementsAre(AllOf(StartsWith("/g/rules/0/to/1/scale: column 1"),
                                                     HasSubstr("\"shrink\"?"))));
  stated = tower();
  stated["terminals"]["ball"]["radius"] = "s*(1+";
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/terminals/ball/radius: column 6")));
  stated = tower();
  stated["terminals"]["ball"]["center"] = json::parse(R"({"xy": [0, 0], "ground": 1})");
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/terminals/ball: has a point")));
  stated = tower();
  stated["terminals"]["cap"]["hight"] = 1;
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/terminals/cap/hight: ")));
  stated = tower();
  stated.erase("rules");
  EXPECT_THAT(problems_of(stated), testing::Contains(StartsWith("/g/rules: is missing")));
  stated = tower();
  stated["parameters"] = {{"rho", 1}, {"shrink", 0.5}};
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/parameters/rho: is no name")));
}

TEST(Grammar, RefusesSymbolsThatNeverEnd) {
  auto stated = tower();
  stated["rules"].erase(2);
  EXPECT_THAT(problems_of(stated), ElementsAre(StartsWith("/g/rules/0/symbol: never ends"),
                                               StartsWith("/g/rules/1/symbol: never ends")));
}

}  // namespace
}  // namespace hoodoo::generator
