#include "engine/base/json.hpp"

#include <gtest/gtest.h>

#include "engine/base/error.hpp"

namespace hoodoo {
namespace {

/// Fault and message of parsing `text`.
std::pair<Fault, std::string> refusal(std::string_view text, const JsonLimits& limits = {}) {
  try {
    parse_json(text, "scene.json", limits);
  } catch (const Error& e) {
    return {e.fault, e.what()};
  }
  ADD_FAILURE() << "took " << text.substr(0, 40);
  return {Fault::internal, ""};
}

TEST(ParseJson, ReadsWhatJsonHolds) {
  const auto json = parse_json(R"({"a": [1, -2, 2.5, true, null], "b": {"c": "d"}})", "");
  EXPECT_EQ(json["a"][0], 1);
  EXPECT_EQ(json["a"][1], -2);
  EXPECT_EQ(json["a"][2], 2.5);
  EXPECT_EQ(json["a"][3], true);
  EXPECT_TRUE(json["a"][4].is_null());
  EXPECT_EQ(json["b"]["c"], "d");
}

TEST(ParseJson, NamesLineAndColumn) {
  const auto [fault, what] = refusal("{\n  \"a\": 1,\n  oops\n}");
  EXPECT_EQ(fault, Fault::bad_input);
  EXPECT_EQ(what.rfind("scene.json: is not JSON: line 3, column ", 0), 0u) << what;
}

TEST(ParseJson, RefusesAKeyThatStandsTwice) {
  EXPECT_EQ(refusal(R"({"a": 1, "a": 2})").first, Fault::bad_input);
}

TEST(ParseJson, RefusesANumberThatNoDoubleHolds) {
  EXPECT_EQ(refusal("[1e999]").first, Fault::bad_input);
}

TEST(ParseJson, RefusesWhatExceedsItsLimits) {
  EXPECT_EQ(refusal(std::string(1'000'000, '[')).first, Fault::limit);
  EXPECT_EQ(refusal("[1,2,3]", {.values = 3}).first, Fault::limit);
  EXPECT_EQ(refusal("\"a long text\"", {.bytes = 5}).first, Fault::limit);
  EXPECT_NO_THROW(parse_json("[[1]]", "", {.depth = 2}));
  EXPECT_EQ(refusal("[[[1]]]", {.depth = 2}).first, Fault::limit);
}

TEST(PointerToken, EscapesTildeAndSlash) { EXPECT_EQ(pointer_token("a~b/c"), "a~0b~1c"); }

}  // namespace
}  // namespace hoodoo
