#include "engine/generator/grammar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/json.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::generator {
namespace {

using nlohmann::json;
using tree::Problems;
using tree::Program;

constexpr std::array<std::string_view, 6> own_names{"u", "s", "rho", "h", "n", "slope"};
constexpr std::array<double, 6> own_values{0.5, 1, 0.5, 1, 1, 0.5};
constexpr std::size_t most_rules = 1000, most_successors = 100, most_parameters = 64;

const Program one{{{tree::Op::number, 1}}, 1};
const Program zero{{{tree::Op::number, 0}}, 1};

class Reader {
 public:
  Reader(const json& stated, std::string where, const ReadTree& read, Problems& problems)
      : stated_(stated), where_(std::move(where)), read_(read), problems_(problems) {}

  std::optional<Grammar> run() {
    const auto before = problems_.size();
    if (!stated_.is_object()) {
      problem(where_, "must be an object");
      return std::nullopt;
    }
    static constexpr std::array<std::string_view, 4> keys{"axiom", "parameters", "rules",
                                                          "terminals"};
    tree::report_unknown_keys(stated_, where_, keys, problems_);
    parameters();
    terminals();
    rules();
    axiom();
    if (problems_.size() == before) expect_ends();
    if (problems_.size() != before) return std::nullopt;
    return std::move(made_);
  }

 private:
  void problem(const std::string& where, std::string what) {
    problems_.push_back({where, std::move(what)});
  }

  /// A part of the grammar that must be there and be of that kind.
  const json* part(std::string_view key, bool list) {
    const auto found = stated_.find(key);
    const auto at = fmt::format("{}/{}", where_, key);
    if (found == stated_.end()) {
      problem(at, "is missing");
      return nullptr;
    }
    if (list ? !found->is_array() : !found->is_object()) {
      problem(at, list ? "must be an array" : "must be an object");
      return nullptr;
    }
    if (found->empty() || found->size() > most_rules) {
      problem(at, fmt::format("must hold 1 to {}, got {}", most_rules, found->size()));
      return nullptr;
    }
    return &*found;
  }

  void parameters() {
    names_.variables.assign(own_names.begin(), own_names.end());
    names_.typical.assign(own_values.begin(), own_values.end());
    const auto found = stated_.find("parameters");
    if (found == stated_.end()) return;
    const auto at = where_ + "/parameters";
    if (!found->is_object() || found->size() > most_parameters) {
      return problem(at, fmt::format("must be an object of at most {} numbers", most_parameters));
    }
    for (const auto& [name, value] : found->items()) {
      const auto here = at + "/" + pointer_token(name);
      if (!tree::is_parameter_name(name) || std::ranges::find(own_names, name) != own_names.end()) {
        problem(here,
                "is no name for a parameter: letters, digits and _, a letter first, at most "
                "32, and no other meaning");
        continue;
      }
      const auto number = tree::read_number(value, here, tree::within(-1e30, 1e30), "1", problems_);
      made_.parameters.push_back(name);
      made_.values.push_back(number.value_or(0));
      names_.variables.push_back(name);
      names_.typical.push_back(number.value_or(0));
    }
  }

  void terminals() {
    const auto* all = part("terminals", false);
    if (all == nullptr) return;
    for (const auto& [name, shape] : all->items()) {
      terminal_names_.push_back(name);
      const auto at = where_ + "/terminals/" + pointer_token(name);
      auto read = ShapeTemplate::read(shape, at, names_, read_, problems_);
      if (read) made_.terminals.push_back({name, *std::move(read)});
    }
  }

  void rules() {
    const auto* all = part("rules", true);
    if (all == nullptr) return;
    for (const auto& rule : *all) {
      if (const auto name = text_of(rule, "symbol"); !name.empty()) {
        if (std::ranges::find(symbol_names_, name) == symbol_names_.end()) {
          symbol_names_.push_back(name);
        }
      }
    }
    for (const auto& name : symbol_names_) made_.symbols.push_back({name, {}});
    for (std::size_t i = 0; i < all->size(); ++i) {
      rule((*all)[i], fmt::format("{}/rules/{}", where_, i));
    }
    for (std::size_t i = 0; i < symbol_names_.size(); ++i) {
      if (std::ranges::find(terminal_names_, symbol_names_[i]) != terminal_names_.end()) {
        problem(where_ + "/terminals/" + pointer_token(symbol_names_[i]),
                "names a symbol that rules replace, too");
      }
    }
  }

  static std::string text_of(const json& object, std::string_view key) {
    if (!object.is_object()) return {};
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
  }

  void rule(const json& stated, const std::string& at) {
    if (!stated.is_object()) return problem(at, "must be an object");
    static constexpr std::array<std::string_view, 3> keys{"symbol", "probability", "to"};
    tree::report_unknown_keys(stated, at, keys, problems_);
    const auto name = text_of(stated, "symbol");
    if (name.empty()) return problem(at + "/symbol", "must be the name of a symbol");
    Grammar::Rule made;
    if (const auto p = stated.find("probability"); p != stated.end()) {
      made.probability = read_formula(*p, at + "/probability", names_, problems_);
    }
    const auto to = stated.find("to");
    if (to == stated.end() || !to->is_array() || to->size() > most_successors) {
      return problem(at + "/to", fmt::format("must be an array of at most {}", most_successors));
    }
    for (std::size_t i = 0; i < to->size(); ++i) {
      if (auto next = successor((*to)[i], fmt::format("{}/to/{}", at, i))) {
        made.to.push_back(*std::move(next));
      }
    }
    const auto which = std::ranges::find(symbol_names_, name) - symbol_names_.begin();
    made_.symbols[static_cast<std::size_t>(which)].rules.push_back(std::move(made));
  }

  std::optional<Grammar::Successor> successor(const json& stated, const std::string& at) {
    Grammar::Successor made;
    made.move = {zero, zero, zero};
    made.scale = one;
    made.angle = zero;
    if (stated.is_string()) return named(stated.get<std::string>(), at, true, true, made);
    if (!stated.is_object()) {
      problem(at, "must be the name of a symbol or terminal, or an object");
      return std::nullopt;
    }
    static constexpr std::array<std::string_view, 5> keys{"symbol", "terminal", "move", "scale",
                                                          "rotate"};
    tree::report_unknown_keys(stated, at, keys, problems_);
    const bool terminal = stated.contains("terminal");
    if (terminal == stated.contains("symbol")) {
      problem(at, "must have either a \"symbol\" or a \"terminal\"");
      return std::nullopt;
    }
    place(stated, at, made);
    const auto* key = terminal ? "terminal" : "symbol";
    return named(text_of(stated, key), fmt::format("{}/{}", at, key), !terminal, terminal, made);
  }

  void place(const json& stated, const std::string& at, Grammar::Successor& made) {
    if (const auto move = stated.find("move"); move != stated.end()) {
      if (!move->is_array() || move->size() != 3) {
        problem(at + "/move", "must be three numbers or formulas in m");
      } else {
        for (std::size_t i = 0; i < 3; ++i) {
          put((*move)[i], fmt::format("{}/move/{}", at, i), made.move[i]);
        }
      }
    }
    if (const auto scale = stated.find("scale"); scale != stated.end()) {
      put(*scale, at + "/scale", made.scale);
    }
    const auto rotate = stated.find("rotate");
    if (rotate == stated.end()) return;
    if (!rotate->is_object()) return problem(at + "/rotate", "must be an object");
    static constexpr std::array<std::string_view, 2> keys{"axis", "angle"};
    tree::report_unknown_keys(*rotate, at + "/rotate", keys, problems_);
    if (const auto axis = rotate->find("axis"); axis != rotate->end()) {
      made.axis = tree::read_direction(*axis, at + "/rotate/axis", problems_).value_or(made.axis);
    }
    const auto angle = rotate->find("angle");
    if (angle == rotate->end()) return problem(at + "/rotate/angle", "is missing");
    put(*angle, at + "/rotate/angle", made.angle);
  }
  void put(const json& value, const std::string& at, Program& into) {
    if (auto formula = read_formula(value, at, names_, problems_)) into = *std::move(formula);
  }

  /// Finds what a successor names.
  std::optional<Grammar::Successor> named(const std::string& name, const std::string& at,
                                          bool symbol, bool terminal, Grammar::Successor& made) {
    const auto find = [&](const std::vector<std::string>& names) {
      return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    if (const auto which = find(symbol_names_); symbol && which < symbol_names_.size()) {
      made.which = which;
      return std::move(made);
    }
    if (const auto which = find(terminal_names_); terminal && which < terminal_names_.size()) {
      made.terminal = true;
      made.which = which;
      return std::move(made);
    }
    std::vector<std::string_view> known;
    if (symbol) known.insert(known.end(), symbol_names_.begin(), symbol_names_.end());
    if (terminal) known.insert(known.end(), terminal_names_.begin(), terminal_names_.end());
    const auto near = tree::nearest(name, known);
    problem(at, fmt::format("names \"{}\", which {}{}", name.substr(0, 80),
                            symbol && terminal ? "no rule replaces and \"terminals\" does not hold"
                            : symbol           ? "no rule replaces"
                                               : "\"terminals\" does not hold",
                            near.empty() ? "" : fmt::format(": did you mean \"{}\"?", near)));
    return std::nullopt;
  }

  void axiom() {
    const auto name = text_of(stated_, "axiom");
    if (name.empty()) return problem(where_ + "/axiom", "must be the name of a symbol");
    Grammar::Successor first;
    if (const auto found = named(name, where_ + "/axiom", true, false, first)) {
      made_.axiom = found->which;
    }
  }

  /// A symbol ends if all that one of its rules puts in its place ends.
  void expect_ends() {
    std::vector<bool> ends(made_.symbols.size());
    const auto rule_ends = [&](const Grammar::Rule& rule) {
      return std::ranges::all_of(
          rule.to, [&](const auto& next) { return next.terminal || ends[next.which]; });
    };
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i] || std::ranges::none_of(made_.symbols[i].rules, rule_ends)) continue;
        ends[i] = changed = true;
      }
    }
    const auto& rules = stated_["rules"];
    for (std::size_t i = 0; i < rules.size(); ++i) {
      const auto name = text_of(rules[i], "symbol");
      const auto which =
          static_cast<std::size_t>(std::ranges::find(symbol_names_, name) - symbol_names_.begin());
      if (ends[which]) continue;
      problem(fmt::format("{}/rules/{}/symbol", where_, i),
              fmt::format("never ends: every rule of \"{}\" leads to symbols that go on without "
                          "end",
                          name));
      ends[which] = true;
    }
  }

  const json& stated_;
  std::string where_;
  const ReadTree& read_;
  Problems& problems_;
  Grammar made_;
  Names names_;
  std::vector<std::string> symbol_names_, terminal_names_;
};

}  // namespace

double* Grammar::parameter(std::string_view name) {
  const auto found = std::ranges::find(parameters, name);
  return found == parameters.end() ? nullptr
                                   : &values[static_cast<std::size_t>(found - parameters.begin())];
}

std::optional<Grammar> read_grammar(const json& stated, const std::string& where,
                                    const ReadTree& read, Problems& problems) {
  return Reader(stated, where, read, problems).run();
}

json grammar_schema() {
  const json formula = {{"type", json::array({"number", "string"})}};
  const json name = {{"type", "string"}, {"minLength", 1}};
  const auto object = [](json properties) {
    return json{
        {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  };
  auto rotate =
      object({{"axis", tree::vector_schema(tree::within(-tree::farthest, tree::farthest), "1")},
              {"angle", formula}});
  rotate["required"] = {"angle"};
  const auto three = json{{"type", "array"}, {"items", formula}, {"minItems", 3}, {"maxItems", 3}};
  const auto next = object({{"symbol", name},
                            {"terminal", name},
                            {"move", three},
                            {"scale", formula},
                            {"rotate", std::move(rotate)}});
  auto rule = object({{"symbol", name},
                      {"probability", formula},
                      {"to",
                       {{"type", "array"},
                        {"items", {{"anyOf", json::array({name, next})}}},
                        {"maxItems", most_successors}}}});
  rule["required"] = {"symbol", "to"};
  auto grammar = object(
      {{"axiom", name},
       {"parameters",
        {{"type", "object"},
         {"additionalProperties", {{"type", "number"}}},
         {"maxProperties", most_parameters}}},
       {"rules",
        {{"type", "array"}, {"items", std::move(rule)}, {"minItems", 1}, {"maxItems", most_rules}}},
       {"terminals",
        {{"type", "object"},
         {"additionalProperties", {{"type", "object"}}},
         {"minProperties", 1},
         {"maxProperties", most_rules}}}});
  grammar["required"] = {"axiom", "rules", "terminals"};
  return grammar;
}

}  // namespace hoodoo::generator
