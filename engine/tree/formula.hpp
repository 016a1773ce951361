#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/base/vector.hpp"

/// The small language of the expression node.
///
///     sum     = product { ("+" | "-") product }
///     product = factor { ("*" | "/") factor }
///     factor  = "-" factor | number | name | name "(" sum { "," sum } ")" | "(" sum ")"
///
/// Names are x, y, z [m], pi, the parameters and the functions below.
namespace hoodoo::tree {

/// What an instruction does to the values on the stack.
enum class Op {
  number,  // pushes `value`
  x,       // push a coordinate
  y,
  z,
  variable,  // pushes the variable of number `value`
  negate,
  add,
  subtract,
  multiply,
  divide,
  pow,
  min,
  max,
  abs,
  clamp,       // clamp(v, low, high)
  mix,         // mix(a, b, t) = a + (b - a) t
  smoothstep,  // smoothstep(a, b, v)
  sin,
  cos,
  sqrt,
  exp,
  log,
  floor,
  noise,  // noise(u, v, w) in [0,1], features of size 1
  fbm     // fbm(u, v, w, octaves), octaves a number
};

struct Instruction {
  Op op;
  double value = 0;  // of a number; the octaves of fbm; which variable
};

/// A formula in the order of its evaluation: each instruction replaces its arguments on a stack.
struct Program {
  std::vector<Instruction> code;
  std::size_t depth = 0;  // of the stack
};

/// Why a text is no formula, and the column, counted from 1, where it stops being one.
struct FormulaError {
  std::size_t column;
  std::string what;
};

using Parameters = std::map<std::string, double>;

inline constexpr std::size_t longest_formula = 4000;  // characters
inline constexpr int deepest_formula = 48;            // nested brackets, signs and calls

/// Reads a formula. A text that is too long or nested too deeply is refused before it is read.
/// `variables` are names whose values each evaluation gives, in their order.
std::variant<Program, FormulaError> parse_formula(std::string_view text,
                                                  const Parameters& parameters,
                                                  std::span<const std::string> variables = {});

/// The value at one place [m], in [-1e30, 1e30]; `variables` as many as were named.
double evaluate(const Program& program, const Vec3& at, std::span<const double> variables,
                std::uint32_t seed = 0);

/// Whether a parameter may have this name: letters, digits and _, a letter first, at most 32, and
/// no other meaning.
bool is_parameter_name(std::string_view name);

}  // namespace hoodoo::tree
