// Every node type through its JSON: what to_json writes, parse_node reads back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "engine/tree/parse.hpp"
#include "engine/tree/read_fields.hpp"
#include "tests/conformance/random_tree.hpp"

namespace hoodoo::tree::conformance {
namespace {

using nlohmann::json;

Family family_of(const NodeKind& kind) {
  return kind.family == Family::any ? Family::terrain : kind.family;
}

class EveryNodeAsJson : public testing::TestWithParam<NodeKind> {
 protected:
  Node random_tree(std::uint64_t seed, int depth) const {
    Random random(seed);
    return GetParam().make(random, family_of(GetParam()), depth);
  }
  std::optional<Node> parse(const json& value) {
    problems.clear();
    Context context;
    find_made_voxels(context);
    return parse_node(value, "/tree", family_of(GetParam()), context, problems);
  }
  bool has_problem_at(const std::string& where) const {
    return std::any_of(problems.begin(), problems.end(),
                       [&](const Problem& p) { return p.where == where; });
  }
  Problems problems;
};

TEST_P(EveryNodeAsJson, ComesBackAsItWas) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Node tree = random_tree(seed, 2);
    // Through text, as a file would hold it.
    const json value = json::parse(to_json(tree).dump());
    const auto again = parse(value);
    ASSERT_TRUE(problems.empty()) << problems[0].where << " " << problems[0].what;
    ASSERT_TRUE(again && *again == tree) << value;
    ASSERT_EQ(to_json(*again).dump(), value.dump());
  }
}

TEST_P(EveryNodeAsJson, ReportsEveryKeyThatIsMissingOrUnknown) {
  const json schema = node_schema()["node." + std::string(GetParam().type)];
  const json whole = to_json(random_tree(1, 1));
  for (const auto& key : schema["required"]) {
    if (key == "type") continue;
    json without = whole;
    without.erase(key.get<std::string>());
    parse(without);
    EXPECT_TRUE(has_problem_at("/tree/" + key.get<std::string>())) << key;
  }
  json with = whole;
  with["colour~/"] = 1;
  parse(with);
  EXPECT_TRUE(has_problem_at("/tree/colour~0~1"));
}

/// Visits every number of a schema's properties.
void for_numbers(const json& properties, const json::json_pointer& at,
                 const std::function<void(const json::json_pointer&, const json&)>& visit) {
  for (const auto& [key, one] : properties.items()) {
    if (one.contains("properties")) for_numbers(one["properties"], at / key, visit);
    const json& type = one.value("type", json());
    if (type == "number" || type == "integer") visit(at / key, one);
    if (type == "array" && one["items"].value("type", "") == "number") {
      visit(at / key / 0, one["items"]);
    }
  }
}

TEST_P(EveryNodeAsJson, RefusesNumbersBeyondItsSchemaAtTheirPointer) {
  const json schema = node_schema()["node." + std::string(GetParam().type)];
  const json whole = to_json(random_tree(2, 1));
  for_numbers(schema["properties"], json::json_pointer(), [&](const auto& at, const json& number) {
    const auto refuse = [&](const json& value) {
      json broken = whole;
      broken[at] = value;
      parse(broken);
      EXPECT_TRUE(has_problem_at("/tree" + at.to_string())) << at.to_string() << " " << value;
    };
    refuse("text");
    refuse(number["maximum"].template get<double>() * 2 + 1);
    if (number.contains("exclusiveMinimum")) {
      refuse(number["exclusiveMinimum"]);
    } else {
      const auto low = number["minimum"].template get<double>();
      refuse(low - 1 - std::abs(low));
    }
    if (number["type"] == "integer") refuse(1.5);
  });
}

TEST_P(EveryNodeAsJson, TakesItsFallbacksFromTheSchema) {
  const json schema = node_schema()["node." + std::string(GetParam().type)];
  json least = to_json(random_tree(3, 1)), full;
  for (const auto& [key, one] : schema["properties"].items()) {
    if (!one.contains("default")) continue;
    least.erase(key);
  }
  const auto node = parse(least);
  ASSERT_TRUE(node && problems.empty());
  full = to_json(*node);
  for (const auto& [key, one] : schema["properties"].items()) {
    if (one.contains("default")) {
      EXPECT_EQ(full[key], one["default"]) << key;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Nodes, EveryNodeAsJson, testing::ValuesIn(node_kinds()), name_of);

}  // namespace

}  // namespace hoodoo::tree::conformance
