#include "engine/tree/nodes/expression.hpp"

#include <fmt/format.h>

#include "engine/tree/composite.hpp"
#include "engine/tree/formula_functions.hpp"

namespace hoodoo::tree {
namespace {

using formula::arguments;
using formula::D;
using formula::held;
using formula::result_of;

constexpr double largest = 1000;  // of the result

/// Turbulence whose features have the size 1, at places given in double. A place's lattice cell is
/// taken from its own coordinates, so that it does not depend on the other places of a batch.
class LatticeNoise {
 public:
  LatticeNoise(double octaves, std::uint32_t seed) : noise_{1, static_cast<int>(octaves), seed} {}

  /// At `n` places; v may be u, too.
  void put(std::size_t n, double* u, const double* v, const double* w) const {
    runs(n, u, v, w, [&](std::size_t from, std::size_t count, const Vec3& corner) {
      turbulence(noise_, corner, part(x_, from, count), part(y_, from, count),
                 part(z_, from, count), {t_.data() + from, count});
    });
    for (std::size_t i = 0; i < n; ++i) u[i] = static_cast<double>(t_[i]);
  }
  void put(std::size_t n, D* u, const D* v, const D* w) const {
    std::array<double, batch_size> a, b, c;
    std::array<float, batch_size> gx, gy, gz;
    for (std::size_t i = 0; i < n; ++i) {
      a[i] = u[i].v;
      b[i] = v[i].v;
      c[i] = w[i].v;
    }
    runs(n, a.data(), b.data(), c.data(),
         [&](std::size_t from, std::size_t count, const Vec3& corner) {
           turbulence_gradient(noise_, corner, part(x_, from, count), part(y_, from, count),
                               part(z_, from, count), {t_.data() + from, count},
                               {gx.data() + from, count}, {gy.data() + from, count},
                               {gz.data() + from, count});
         });
    for (std::size_t i = 0; i < n; ++i) {
      const auto x = static_cast<double>(gx[i]), y = static_cast<double>(gy[i]),
                 z = static_cast<double>(gz[i]);
      const D p = u[i], q = v[i], r = w[i];
      u[i] = {static_cast<double>(t_[i]), x * p.x + y * q.x + z * r.x, x * p.y + y * q.y + z * r.y,
              x * p.z + y * q.z + z * r.z};
    }
  }
  /// From the value in the middle and the steepest slope.
  void put(std::size_t, Interval* u, const Interval* v, const Interval* w) const {
    const auto middle = [](const Interval& a) { return (a.low + a.high) / 2; };
    double x = middle(*u), y = middle(*v), z = middle(*w);
    const double half = length({u->width(), v->width(), w->width()}) / 2;
    put(1, &x, &y, &z);
    const double far = turbulence_slope(noise_) * half + 1e-4;
    *u = {std::max(0.0, x - far), std::min(1.0, x + far)};
  }

 private:
  using Row = std::array<float, batch_size>;
  static std::span<const float> part(const Row& row, std::size_t from, std::size_t n) {
    return {row.data() + from, n};
  }
  /// Calls `use` for every run of places of the same 16 x 16 x 16 cells, whose places relative to
  /// its corner then stand in x_, y_, z_.
  template <class Use>
  void runs(std::size_t n, const double* u, const double* v, const double* w, Use use) const {
    const auto corner_of = [](double a) { return std::floor(a / 16) * 16; };
    for (std::size_t from = 0; from < n;) {
      const Vec3 corner{corner_of(u[from]), corner_of(v[from]), corner_of(w[from])};
      std::size_t i = from;
      for (; i < n; ++i) {
        if (Vec3{corner_of(u[i]), corner_of(v[i]), corner_of(w[i])} != corner) break;
        x_[i] = static_cast<float>(u[i] - corner.x);
        y_[i] = static_cast<float>(v[i] - corner.y);
        z_[i] = static_cast<float>(w[i] - corner.z);
      }
      use(from, i - from, corner);
      from = i;
    }
  }
  Turbulence noise_;
  mutable Row x_, y_, z_, t_;
};

/// The stack of an evaluation: rows of n values each.
template <class T>
class Stack {
 public:
  Stack(std::size_t depth, std::size_t n) : n_(n), values_(depth * n) {}
  T* push() { return row(height_++); }
  void pop(std::size_t rows) { height_ -= rows; }
  /// The row `down` below the top.
  T* top(std::size_t down = 0) { return row(height_ - 1 - down); }

 private:
  T* row(std::size_t i) { return values_.data() + i * n_; }
  std::size_t n_, height_ = 0;
  std::vector<T> values_;
};

/// Replaces the arguments on the stack by the result.
template <class T>
void apply(const Instruction& step, std::uint32_t seed, std::size_t n, Stack<T>& stack) {
  switch (arguments(step.op)) {
    case 1: {
      T* a = stack.top();
      for (std::size_t i = 0; i < n; ++i) a[i] = held(result_of(step.op, a[i]));
      return;
    }
    case 2: {
      T *a = stack.top(1), *b = stack.top();
      for (std::size_t i = 0; i < n; ++i) a[i] = held(result_of(step.op, a[i], b[i]));
      return stack.pop(1);
    }
    case 3: {
      T *a = stack.top(2), *b = stack.top(1), *c = stack.top();
      for (std::size_t i = 0; i < n; ++i) a[i] = held(result_of(step.op, a[i], b[i], c[i]));
      return stack.pop(2);
    }
    default: {
      const LatticeNoise noise(step.op == Op::fbm ? step.value : 1, seed);
      noise.put(n, stack.top(2), stack.top(1), stack.top());
      return stack.pop(2);
    }
  }
}

/// The formula at n places; `place(axis, i)` gives their coordinates.
template <class T, class Place>
std::vector<T> run(const Program& program, std::uint32_t seed, std::size_t n, Place place) {
  Stack<T> stack(program.depth, n);
  for (const Instruction& step : program.code) {
    if (arguments(step.op) > 0) {
      apply(step, seed, n, stack);
      continue;
    }
    T* top = stack.push();
    const int axis = static_cast<int>(step.op) - static_cast<int>(Op::x);
    for (std::size_t i = 0; i < n; ++i) {
      top[i] = step.op == Op::number ? formula::constant_of<T>(step.value) : place(axis, i);
    }
  }
  return {stack.top(), stack.top() + n};
}

/// Over a box.
Interval bounds_of(const Program& program, std::uint32_t seed, const Box& box) {
  const auto side = [&](int axis, std::size_t) {
    return held(Interval{box.min[axis], box.max[axis]});
  };
  return outward(clamp(run<Interval>(program, seed, 1, side)[0], -largest, largest));
}

class ExpressionKernel final : public Kernel {
 public:
  ExpressionKernel(Program program, std::uint32_t seed, const Vec3& origin)
      : program_(std::move(program)), seed_(seed), origin_(origin) {}

  void values(const Points& at, std::span<float> out) const override {
    const auto place = [&](int axis, std::size_t i) { return coordinate(at, axis, i); };
    const auto v = run<double>(program_, seed_, at.size(), place);
    for (std::size_t i = 0; i < at.size(); ++i) {
      out[i] = static_cast<float>(clamped(v[i], -largest, largest));
    }
  }
  void gradients(const Points& at, std::span<float> out, const Gradients& g) const override {
    const auto place = [&](int axis, std::size_t i) {
      return D(coordinate(at, axis, i), axis == 0 ? 1 : 0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0);
    };
    const auto v = run<D>(program_, seed_, at.size(), place);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const D f = clamped(v[i], -largest, largest);
      out[i] = static_cast<float>(f.v);
      g.x[i] = static_cast<float>(f.x);
      g.y[i] = static_cast<float>(f.y);
      g.z[i] = static_cast<float>(f.z);
    }
  }
  void explain(int depth, std::vector<std::string>& lines) const override {
    lines.push_back(explained(depth, Expression::type));
  }

 private:
  double coordinate(const Points& at, int axis, std::size_t i) const {
    const auto& row = axis == 0 ? at.x : axis == 1 ? at.y : at.z;
    return origin_[axis] + static_cast<double>(row[i]);
  }
  Program program_;
  std::uint32_t seed_;
  Vec3 origin_;
};

/// Of a formula that has been checked; 0 of one that has not.
Program program_of(const Expression& node) {
  auto parsed = parse_formula(node.formula, node.parameters);
  if (auto* program = std::get_if<Program>(&parsed)) return std::move(*program);
  return {{{Op::number, 0}}, 1};
}

}  // namespace

void Expression::check(const std::string& where, std::vector<Problem>& problems) const {
  bool named = true;
  for (const auto& [name, value] : parameters) {
    if (is_parameter_name(name)) continue;
    named = false;
    problems.push_back({where + "/parameters",
                        fmt::format("\"{}\" is no name for a parameter: letters, digits and _, a "
                                    "letter first, at most 32, and no other meaning",
                                    name.substr(0, 40))});
  }
  if (!named) return;
  const auto parsed = parse_formula(formula, parameters);
  if (const auto* error = std::get_if<FormulaError>(&parsed)) {
    problems.push_back(
        {where + "/formula", fmt::format("column {}: {}", error->column, error->what)});
  }
}

Support Expression::support(std::span<const Support>) const {
  return {Box::everywhere(), bounds_of(program_of(*this), seed, Box::everywhere()),
          Support::no_bound};
}

Compiled Expression::compile_node(const std::vector<Node>&, const Block& block) const {
  Program program = program_of(*this);
  const Box box = block.box.grown(rounding(block.box, block));
  const Interval bounds = bounds_of(program, seed, box);
  return {std::make_unique<ExpressionKernel>(std::move(program), seed, block.origin), bounds};
}

Node Expression::prune_node(const std::vector<Node>&, const Box&, double) const {
  return {*this, {}};
}

}  // namespace hoodoo::tree
