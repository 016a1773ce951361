#include "engine/generator/shape_template.hpp"

#include <fmt/format.h>

#include <array>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include "engine/base/random.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::generator {
namespace {

using nlohmann::json;
using namespace tree;

constexpr Range coordinate = within(-farthest, farthest);

/// A number of that range to read in the place of a formula.
double in_range(double typical, const Range& range) {
  if (range.holds(typical)) return typical;
  return range.holds(1) ? 1 : range.high;
}

/// Finds the formulas of a tree's JSON and puts numbers in their places.
struct Finder {
  const Names& names;
  Problems& problems;
  std::vector<ShapeTemplate::Filled>& filled;
  std::vector<std::size_t> path{};
  bool checked = false;

  void find(json& node, const std::string& where) {
    const auto type = node.is_object() ? node.find("type") : node.end();
    if (!node.is_object() || type == node.end() || !type->is_string()) return;
    find_any(type->get<std::string>(), node, where, static_cast<AnyNode*>(nullptr));
  }

 private:
  template <class... N>
  void find_any(const std::string& type, json& node, const std::string& where,
                std::variant<N...>*) {
    const auto take = [&]<class T>(T*) {
      if (type == T::type) find_in<T>(node, where);
    };
    (take(static_cast<N*>(nullptr)), ...);
  }

  template <class N>
  void find_in(json& node, const std::string& where) {
    if constexpr (requires(N n) { n.check(where, problems); }) checked = true;
    std::apply([&](const auto&... f) { (field<N>(f, node, where), ...); }, N::fields());
    std::size_t next = 0;
    for (const Slot& slot : std::span<const Slot>(N::slots)) {
      const auto found = node.find(slot.key);
      if (found == node.end()) continue;
      const auto at = fmt::format("{}/{}", where, slot.key);
      if (!slot.list) {
        below(*found, at, next++);
        continue;
      }
      if (!found->is_array()) continue;
      for (std::size_t i = 0; i < found->size(); ++i) {
        below((*found)[i], fmt::format("{}/{}", at, i), next++);
      }
    }
  }
  void below(json& node, const std::string& where, std::size_t child) {
    path.push_back(child);
    find(node, where);
    path.pop_back();
  }

  /// Takes a formula out of `value`, if there is one.
  void take(json& value, const std::string& where, const Range& range, ShapeTemplate::Put put) {
    if (!value.is_string()) return;
    auto formula = read_formula(value, where, names, problems);
    double typical = 0;
    if (formula) {
      typical = evaluate(*formula, {}, names.typical);
      filled.push_back({path, *std::move(formula), std::move(put)});
    }
    value = in_range(typical, range);
  }

  template <class N, class Field>
  void field(const Field&, json&, const std::string&) {}

  template <class N>
  void field(const Number<N>& f, json& node, const std::string& where) {
    number<N>(f.key, f.range, node, where, [m = f.member](N& n, double v) { n.*m = v; });
  }
  template <class N>
  void field(const OptionalNumber<N>& f, json& node, const std::string& where) {
    number<N>(f.key, f.range, node, where, [m = f.member](N& n, double v) { n.*m = v; });
  }
  template <class N>
  void field(const Vector<N>& f, json& node, const std::string& where) {
    three<N>(f.key, f.range, node, where,
             [m = f.member](N& n, int axis, double v) { (n.*m)[axis] = v; });
  }
  template <class N>
  void field(const Position<N>& f, json& node, const std::string& where) {
    three<N>(f.key, coordinate, node, where,
             [m = f.member](N& n, int axis, double v) { (n.*m).value[axis] = v; });
  }
  template <class N>
  void field(const Positions<N>& f, json& node, const std::string& where) {
    const auto found = node.find(f.key);
    if (found == node.end() || !found->is_array()) return;
    for (std::size_t i = 0; i < found->size(); ++i) {
      coordinates<N>((*found)[i], fmt::format("{}/{}/{}", where, f.key, i), coordinate,
                     [m = f.member, i](N& n, int axis, double v) { (n.*m)[i].value[axis] = v; });
    }
  }
  template <class N, class G>
  void field(const Group<N, G>& f, json& node, const std::string& where) {
    const auto found = node.find(f.key);
    if (found == node.end() || !found->is_object()) return;
    const auto at = fmt::format("{}/{}", where, f.key);
    const auto inner = [&](const auto& g) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(g)>, Number<G>>) {
        number<N>(g.key, g.range, *found, at,
                  [m = f.member, k = g.member](N& n, double v) { (n.*m).*k = v; });
      }
    };
    std::apply([&](const auto&... g) { (inner(g), ...); }, G::fields());
  }

  template <class N, class Set>
  void number(std::string_view key, const Range& range, json& owner, const std::string& where,
              Set set) {
    const auto found = owner.find(key);
    if (found == owner.end()) return;
    take(*found, fmt::format("{}/{}", where, key), range, [range, set](AnyNode& n, double v) {
      set(std::get<N>(n), v);
      return range.holds(v);
    });
  }
  template <class N, class Set>
  void three(std::string_view key, const Range& range, json& owner, const std::string& where,
             Set set) {
    const auto found = owner.find(key);
    if (found != owner.end()) {
      coordinates<N>(*found, fmt::format("{}/{}", where, key), range, set);
    }
  }
  template <class N, class Set>
  void coordinates(json& value, const std::string& where, const Range& range, Set set) {
    if (!value.is_array() || value.size() != 3) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = static_cast<int>(i);
      take(value[i], fmt::format("{}/{}", where, i), range,
           [range, set, axis](AnyNode& n, double v) {
             set(std::get<N>(n), axis, v);
             return range.holds(v);
           });
    }
  }
};

/// No rule between its numbers is broken.
bool is_sound(const Node& tree) {
  Problems problems;
  std::visit(
      [&](const auto& n) {
        if constexpr (requires { n.check("", problems); }) n.check("", problems);
      },
      tree.value);
  if (!problems.empty()) return false;
  for (const auto& child : tree.children) {
    if (!is_sound(child)) return false;
  }
  return true;
}

}  // namespace

std::optional<Program> read_formula(const json& value, const std::string& where, const Names& names,
                                    Problems& problems) {
  if (value.is_number()) {
    const auto number = read_number(value, where, within(-1e30, 1e30), "1", problems);
    if (!number) return std::nullopt;
    return Program{{{Op::number, *number}}, 1};
  }
  if (!value.is_string()) {
    problems.push_back({where, "must be a number or a formula"});
    return std::nullopt;
  }
  auto parsed = parse_formula(value.get_ref<const std::string&>(), {}, names.variables);
  if (const auto* error = std::get_if<FormulaError>(&parsed)) {
    problems.push_back({where, fmt::format("column {}: {}", error->column, error->what)});
    return std::nullopt;
  }
  return std::get<Program>(std::move(parsed));
}

double Values::of(const Program& formula, std::uint64_t number) {
  if (formula.code.size() == 1 && formula.code[0].op == Op::number) return formula.code[0].value;
  variables[0] = unit_real(random_bits(key, number));
  return evaluate(formula, at, variables, static_cast<std::uint32_t>(key));
}

std::optional<ShapeTemplate> ShapeTemplate::read(json stated, const std::string& where,
                                                 const Names& names, const ReadTree& read,
                                                 Problems& problems) {
  const auto before = problems.size();
  ShapeTemplate made;
  Finder finder{names, problems, made.filled_};
  finder.find(stated, where);
  made.checked_ = finder.checked;
  auto tree = read(stated, where);
  if (!tree) return std::nullopt;
  expect_movable(*tree, where, problems);
  if (problems.size() != before) return std::nullopt;
  made.tree_ = *std::move(tree);
  return made;
}

std::optional<Node> ShapeTemplate::shape(Values& values, std::uint64_t first) const {
  Node made = tree_;
  for (std::size_t i = 0; i < filled_.size(); ++i) {
    Node* node = &made;
    for (const auto child : filled_[i].path) node = &node->children[child];
    if (!filled_[i].put(node->value, values.of(filled_[i].formula, first + i))) return std::nullopt;
  }
  if (checked_ && !is_sound(made)) return std::nullopt;
  return made;
}

}  // namespace hoodoo::generator
