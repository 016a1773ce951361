#include "engine/tree/formula.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "engine/base/math.hpp"
#include "engine/base/noise.hpp"
#include "engine/tree/formula_functions.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::tree {
namespace {

struct Function {
  std::string_view name;
  Op op;
  std::size_t arguments;
};
constexpr std::array<Function, 15> functions{{{"pow", Op::pow, 2},
                                              {"min", Op::min, 2},
                                              {"max", Op::max, 2},
                                              {"abs", Op::abs, 1},
                                              {"clamp", Op::clamp, 3},
                                              {"mix", Op::mix, 3},
                                              {"smoothstep", Op::smoothstep, 3},
                                              {"sin", Op::sin, 1},
                                              {"cos", Op::cos, 1},
                                              {"sqrt", Op::sqrt, 1},
                                              {"exp", Op::exp, 1},
                                              {"log", Op::log, 1},
                                              {"floor", Op::floor, 1},
                                              {"noise", Op::noise, 3},
                                              {"fbm", Op::fbm, 4}}};

struct Coordinate {
  std::string_view name;
  Op op;
};
constexpr std::array<Coordinate, 3> coordinates{{{"x", Op::x}, {"y", Op::y}, {"z", Op::z}}};

template <class List>
auto find(const List& list, std::string_view name) {
  return std::find_if(list.begin(), list.end(), [&](const auto& one) { return one.name == name; });
}

// ASCII alone, whatever the locale.
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// Recursive descent; a problem is thrown, within this file alone.
class Parser {
 public:
  Parser(std::string_view text, const Parameters& parameters,
         std::span<const std::string> variables)
      : text_(text), parameters_(parameters), variables_(variables) {}

  Program program() {
    if (text_.size() > longest_formula) {
      at_ = longest_formula;
      fail(fmt::format("is longer than {} characters", longest_formula));
    }
    sum();
    if (at_ < text_.size()) fail(fmt::format("did not expect {}", shown()));
    return std::move(program_);
  }

 private:
  [[noreturn]] void fail(std::string what) const { throw FormulaError{at_ + 1, std::move(what)}; }
  [[noreturn]] void fail_at(std::size_t place, std::string what) const {
    throw FormulaError{place + 1, std::move(what)};
  }
  std::string shown() const {
    if (at_ >= text_.size()) return "the end";
    const char c = text_[at_];
    return c > ' ' && c < 127 ? fmt::format("\"{}\"", c) : "this character";
  }

  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) {
      ++at_;
    }
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    skip();
    return true;
  }
  void expect(char c) {
    if (!take(c)) fail(fmt::format("expected \"{}\", not {}", c, shown()));
  }
  /// `pushed` values take the place of `taken`.
  void put(Op op, std::size_t taken, double value = 0) {
    program_.code.push_back({op, value});
    height_ += 1 - taken;
    program_.depth = std::max(program_.depth, height_);
  }

  void sum() {
    product();
    for (;;) {
      const bool add = take('+');
      if (!add && !take('-')) return;
      product();
      put(add ? Op::add : Op::subtract, 2);
    }
  }
  void product() {
    factor();
    for (;;) {
      const bool times = take('*');
      if (!times && !take('/')) return;
      factor();
      put(times ? Op::multiply : Op::divide, 2);
    }
  }
  void factor() {
    if (++nested_ > deepest_formula) {
      fail(fmt::format("is nested deeper than {}", deepest_formula));
    }
    skip();
    if (take('-')) {
      factor();
      put(Op::negate, 1);
    } else if (take('(')) {
      sum();
      expect(')');
    } else if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.')) {
      put(Op::number, 0, number());
    } else if (at_ < text_.size() && is_letter(text_[at_])) {
      name();
    } else {
      fail(fmt::format("expected a number, a name or \"(\", not {}", shown()));
    }
    --nested_;
  }

  double number() {
    double value = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc() || !(std::abs(value) <= 1e30)) {
      fail("is no number between -1e30 and 1e30");
    }
    at_ = static_cast<std::size_t>(end - text_.data());
    skip();
    return value;
  }

  void name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string_view word = text_.substr(start, at_ - start);
    if (take('(')) return call(word, start);
    const auto coordinate = find(coordinates, word);
    const auto parameter = parameters_.find(std::string(word));
    const auto variable = std::ranges::find(variables_, word);
    if (coordinate != coordinates.end()) {
      put(coordinate->op, 0);
    } else if (variable != variables_.end()) {
      put(Op::variable, 0, static_cast<double>(variable - variables_.begin()));
    } else if (word == "pi") {
      put(Op::number, 0, pi);
    } else if (parameter != parameters_.end()) {
      put(Op::number, 0, parameter->second);
    } else if (find(functions, word) != functions.end()) {
      fail(fmt::format("expected \"(\" after {}, not {}", word, shown()));
    } else {
      fail_at(start, unknown(word));
    }
  }

  std::string unknown(std::string_view word) const {
    std::vector<std::string_view> known{"x", "y", "z", "pi"};
    for (const auto& [name, value] : parameters_) known.push_back(name);
    known.insert(known.end(), variables_.begin(), variables_.end());
    for (const Function& function : functions) known.push_back(function.name);
    const std::string_view near = nearest(word, known);
    return fmt::format("\"{}\" is neither a coordinate, a parameter nor a function{}",
                       word.substr(0, 40),
                       near.empty() ? "" : fmt::format(", did you mean \"{}\"?", near));
  }

  void call(std::string_view word, std::size_t start) {
    const auto function = find(functions, word);
    if (function == functions.end()) fail_at(start, unknown(word));
    const std::size_t values = function->op == Op::fbm ? 3 : function->arguments;
    double octaves = 0;
    for (std::size_t i = 0; i < function->arguments; ++i) {
      if (i > 0) {
        if (!take(',')) {
          fail(fmt::format("expected \",\": {} takes {} arguments", word, function->arguments));
        }
      }
      if (i < values) {
        sum();
      } else {
        octaves = whole_octaves();
      }
    }
    if (!take(')')) {
      fail(fmt::format("expected \")\": {} takes {} argument{}", word, function->arguments,
                       function->arguments == 1 ? "" : "s"));
    }
    put(function->op, values, octaves);
  }

  double whole_octaves() {
    skip();
    const std::size_t start = at_;
    const bool digit = at_ < text_.size() && is_digit(text_[at_]);
    const double value = digit ? number() : 0;
    if (value < 1 || value > 12 || value != std::floor(value)) {
      fail_at(start, "fbm takes 1 to 12 octaves, written as a number");
    }
    return value;
  }

  std::string_view text_;
  const Parameters& parameters_;
  std::span<const std::string> variables_;
  Program program_;
  std::size_t at_ = 0, height_ = 0;
  int nested_ = 0;
};

}  // namespace

std::variant<Program, FormulaError> parse_formula(std::string_view text,
                                                  const Parameters& parameters,
                                                  std::span<const std::string> variables) {
  try {
    return Parser(text, parameters, variables).program();
  } catch (FormulaError& error) {
    return std::move(error);
  }
}

double evaluate(const Program& program, const Vec3& at, std::span<const double> variables,
                std::uint32_t seed) {
  using formula::held;
  std::vector<double> stack;
  stack.reserve(program.depth);
  for (const Instruction& step : program.code) {
    const std::size_t taken = formula::arguments(step.op);
    double made = 0;
    const double* last = stack.data() + stack.size();
    if (step.op == Op::number) {
      made = step.value;
    } else if (step.op == Op::variable) {
      made = held(variables[static_cast<std::size_t>(step.value)]);
    } else if (taken == 0) {
      made = at[static_cast<int>(step.op) - static_cast<int>(Op::x)];
    } else if (step.op == Op::noise || step.op == Op::fbm) {
      const int octaves = step.op == Op::fbm ? static_cast<int>(step.value) : 1;
      made = turbulence_at({1, octaves, seed}, {last[-3], last[-2], last[-1]});
    } else if (taken == 1) {
      made = formula::result_of(step.op, last[-1]);
    } else if (taken == 2) {
      made = formula::result_of(step.op, last[-2], last[-1]);
    } else {
      made = formula::result_of(step.op, last[-3], last[-2], last[-1]);
    }
    stack.resize(stack.size() - std::min<std::size_t>(taken, 3));
    stack.push_back(held(made));
  }
  return stack.back();
}

bool is_parameter_name(std::string_view name) {
  if (name.empty() || name.size() > 32 || !is_letter(name[0])) return false;
  for (const char c : name) {
    if (!is_letter(c) && !is_digit(c)) return false;
  }
  return name != "pi" && find(coordinates, name) == coordinates.end() &&
         find(functions, name) == functions.end();
}

}  // namespace hoodoo::tree
