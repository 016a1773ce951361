#include "engine/tree/formula.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/tree/probe.hpp"

namespace hoodoo::tree {
namespace {

double at(const std::string& text, const Vec3& p = {2, 3, 5}, const Parameters& parameters = {}) {
  Expression e;
  e.formula = text;
  e.parameters = parameters;
  std::vector<Problem> problems;
  e.check("", problems);
  for (const Problem& problem : problems) ADD_FAILURE() << text << ": " << problem.what;
  return value({e}, p);
}

TEST(Formula, BindsAsArithmeticDoes) {
  EXPECT_NEAR(at("1 + 2 * 3"), 7, 1e-6);
  EXPECT_NEAR(at("(1 + 2) * 3"), 9, 1e-6);
  EXPECT_NEAR(at("8 / 4 / 2"), 1, 1e-6);
  EXPECT_NEAR(at("8 - 4 - 2"), 2, 1e-6);
  EXPECT_NEAR(at("-x * -y"), 6, 1e-6);
  EXPECT_NEAR(at("2 - -z"), 7, 1e-6);
  EXPECT_NEAR(at(" 1.5e1+.5 "), 15.5, 1e-5);
  EXPECT_NEAR(at("depth * x", {2, 0, 0}, {{"depth", 4.5}}), 9, 1e-6);
}

TEST(Formula, KnowsItsFunctions) {
  EXPECT_NEAR(at("pow(x, 3)"), 8, 1e-6);
  EXPECT_NEAR(at("pow(-x, 3)"), -8, 1e-6);
  EXPECT_NEAR(at("pow(2, 0.5)"), std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(at("min(x, y) + max(y, z) + abs(-1)"), 8, 1e-6);
  EXPECT_NEAR(at("clamp(z, 0, 1)"), 1, 1e-6);
  EXPECT_NEAR(at("mix(10, 20, 0.25)"), 12.5, 1e-6);
  EXPECT_NEAR(at("smoothstep(0, 4, x - 1)"), 0.15625, 1e-6);
  EXPECT_NEAR(at("sin(pi / 6) + cos(pi / 3)"), 1, 1e-6);
  EXPECT_NEAR(at("sqrt(16) + floor(-1.5)"), 2, 1e-6);
  EXPECT_NEAR(at("log(exp(3))"), 3, 1e-6);
}

TEST(Formula, IsDefinedEverywhere) {
  EXPECT_EQ(at("1 / 0"), 0);
  EXPECT_EQ(at("sqrt(-4)"), 0);
  EXPECT_EQ(at("pow(-2, 0.5)"), 0);
  EXPECT_EQ(at("exp(1000)"), 1000);
  EXPECT_EQ(at("exp(1000) - exp(1000)"), 0);
}

TEST(Formula, HasNoiseThatRepeatsWithItsSeed) {
  Expression e;
  e.formula = "noise(x / 7, y / 7, z / 7)";
  const double first = value({e}, {100, 20, 3});
  EXPECT_EQ(value({e}, {100, 20, 3}), first);
  EXPECT_GE(first, 0);
  EXPECT_LE(first, 1);
  e.seed = 8;
  EXPECT_NE(value({e}, {100, 20, 3}), first);
}

struct Wrong {
  const char* text;
  std::size_t column;
  const char* what;
};

TEST(Formula, SaysWhereItIsWrong) {
  const Wrong all[] = {{"", 1, "expected a number"},
                       {"1 +", 4, "the end"},
                       {"1 + * 2", 5, "not \"*\""},
                       {"(1 + 2", 7, "expected \")\""},
                       {"1 2", 3, "did not expect"},
                       {"x + speed", 5, "\"speed\""},
                       {"sine(x)", 1, "did you mean \"sin\""},
                       {"sin", 4, "expected \"(\""},
                       {"pow(x)", 6, "takes 2 arguments"},
                       {"abs(x, y)", 6, "takes 1 argument"},
                       {"fbm(x, y, z, 13)", 14, "1 to 12 octaves"},
                       {"fbm(x, y, z, x)", 14, "1 to 12 octaves"},
                       {"1e99", 1, "no number"},
                       {"x $ y", 3, "\"$\""}};
  for (const Wrong& one : all) {
    const auto parsed = parse_formula(one.text, {});
    const auto* error = std::get_if<FormulaError>(&parsed);
    ASSERT_TRUE(error) << one.text;
    EXPECT_EQ(error->column, one.column) << one.text;
    EXPECT_NE(error->what.find(one.what), std::string::npos) << one.text << ": " << error->what;
  }
}

TEST(Formula, IsRefusedWhenItIsTooLongOrTooDeep) {
  const auto refused = [](const std::string& text) {
    return std::holds_alternative<FormulaError>(parse_formula(text, {}));
  };
  EXPECT_TRUE(refused(std::string(5000, '1')));
  EXPECT_TRUE(refused(std::string(100, '(') + "1" + std::string(100, ')')));
  EXPECT_TRUE(refused(std::string(100, '-') + "1"));
  EXPECT_FALSE(refused(std::string(40, '(') + "1" + std::string(40, ')')));
}

TEST(Formula, TakesParametersUnderNamesOfTheirOwn) {
  for (const char* good : {"a", "depth_2", "X", "a123456789012345678901234567890"}) {
    EXPECT_TRUE(is_parameter_name(good)) << good;
  }
  for (const char* bad :
       {"", "x", "pi", "sin", "2a", "a b", "a123456789012345678901234567890123"}) {
    EXPECT_FALSE(is_parameter_name(bad)) << bad;
  }
}

}  // namespace
}  // namespace hoodoo::tree
