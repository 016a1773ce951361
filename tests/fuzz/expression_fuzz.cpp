// Any bytes as a formula: refused at a column, or evaluated. What it gives is a number within its
// bounds, the same with and without its gradient.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <variant>
#include <vector>

#include "engine/tree/evaluate.hpp"
#include "engine/tree/formula.hpp"

using namespace hoodoo;

namespace {

const tree::Parameters parameters{{"a", 0.5}, {"b", -3}, {"huge", 1e30}};

void require(bool holds) {
  if (!holds) std::abort();
}

/// A few points of a box, its corners among them.
struct Cloud {
  std::vector<float> x, y, z;
  explicit Cloud(float side) {
    for (int i = 0; i < 27; ++i) {
      x.push_back(side * static_cast<float>(i % 3) / 2);
      y.push_back(side * static_cast<float>(i / 3 % 3) / 2);
      z.push_back(side * static_cast<float>(i / 9) / 2);
    }
  }
  tree::Points points() const { return {x, y, z}; }
};

void evaluate(const tree::Node& tree, const Vec3& origin, float side) {
  const double s = static_cast<double>(side);
  const auto compiled = tree::compile(tree, {origin, {origin, origin + Vec3{s, s, s}}});
  if (!compiled.kernel) return;
  const Cloud cloud(side);
  const std::size_t n = cloud.x.size();
  std::vector<float> values(n), same(n), gx(n), gy(n), gz(n);
  compiled.kernel->values(cloud.points(), values);
  compiled.kernel->gradients(cloud.points(), same, {gx, gy, gz});
  for (std::size_t i = 0; i < n; ++i) {
    require(std::isfinite(values[i]) && values[i] == same[i]);
    require(compiled.bounds.contains(static_cast<double>(values[i])));
    require(!std::isnan(gx[i]) && !std::isnan(gy[i]) && !std::isnan(gz[i]));
  }
}

}  // namespace

// libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto parsed = tree::parse_formula(text, parameters);
  if (const auto* error = std::get_if<tree::FormulaError>(&parsed)) {
    require(error->column >= 1 && error->column <= size + 1 && !error->what.empty());
    return 0;
  }
  tree::Expression expression;
  expression.formula = text;
  expression.parameters = parameters;
  const tree::Node tree{expression, {}};
  evaluate(tree, {0, 0, 0}, 16);
  evaluate(tree, {-3e5, 7e6, 1e3}, 0.25F);
  return 0;
}
