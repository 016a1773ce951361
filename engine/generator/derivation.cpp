#include <algorithm>
#include <utility>

#include "engine/base/random.hpp"
#include "engine/generator/grammar.hpp"
#include "engine/generator/placement.hpp"

namespace hoodoo::generator {
namespace {

/// What is drawn for a symbol or a successor, by number.
enum Draw : std::uint64_t { choice = 0, move = 1, scale = 4, angle = 5, probabilities = 16 };
constexpr std::uint64_t shapes = 1'000'000;       // first formula of a terminal's tree
constexpr std::uint64_t successors = 2'000'000;   // keys of successors
constexpr double smallest = 1e-6, largest = 1e6;  // s [m]

/// A symbol that is to be replaced.
struct Standing {
  std::size_t symbol;
  Placement frame;
  double size;
  int steps;  // from the axiom
  std::uint64_t key;
};

class Derivation {
 public:
  Derivation(const Grammar& grammar, const Axiom& axiom, int deepest,
             const ResistanceAt& resistance)
      : grammar_(grammar), axiom_(axiom), deepest_(deepest), resistance_(resistance) {
    values_.variables = {0, 0, 0, 0, 0, axiom.slope};
    const auto& own = axiom.values.empty() ? grammar.values : axiom.values;
    values_.variables.insert(values_.variables.end(), own.begin(), own.end());
  }

  Derived run() {
    open_.push_back({grammar_.axiom, {axiom_.at}, axiom_.size, 0, axiom_.key});
    while (!open_.empty()) {
      const Standing symbol = std::move(open_.back());
      open_.pop_back();
      replace(symbol);
    }
    return std::move(made_);
  }

 private:
  void see(const Vec3& at, double size, int steps, std::uint64_t key) {
    values_.at = at;
    values_.key = key;
    auto& v = values_.variables;
    v[1] = size;
    v[2] = resistance_(at);
    v[3] = at.z - axiom_.at.z;
    v[4] = steps;
  }

  void replace(const Standing& symbol) {
    if (symbol.steps >= deepest_) {
      ++made_.too_deep;
      return;
    }
    if (made_.symbols >= most_symbols) {
      ++made_.too_many;
      return;
    }
    ++made_.symbols;
    see(symbol.frame.at, symbol.size, symbol.steps, symbol.key);
    const auto* rule = choose(grammar_.symbols[symbol.symbol].rules);
    if (rule == nullptr) {
      ++made_.dead_ends;
      return;
    }
    std::vector<Standing> next;
    for (std::size_t i = 0; i < rule->to.size(); ++i) {
      next.push_back(follow(symbol, rule->to[i], random_bits(symbol.key, successors + i)));
    }
    const auto first = open_.size();
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (rule->to[i].terminal) {
        finish(next[i]);
      } else {
        open_.push_back(std::move(next[i]));
      }
    }
    std::reverse(open_.begin() + static_cast<std::ptrdiff_t>(first), open_.end());
  }

  const Grammar::Rule* choose(const std::vector<Grammar::Rule>& rules) {
    std::vector<double> share(rules.size());
    double stated = 0;
    std::size_t open = 0;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (!rules[i].probability) {
        ++open;
        continue;
      }
      share[i] = std::max(0.0, values_.of(*rules[i].probability, probabilities + i));
      stated += share[i];
    }
    double sum = 0;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (!rules[i].probability) share[i] = std::max(0.0, 1 - stated) / static_cast<double>(open);
      sum += share[i];
    }
    double left = unit_real(random_bits(values_.key, choice)) * sum;
    const Grammar::Rule* last = nullptr;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      if (!(share[i] > 0)) continue;
      last = &rules[i];
      if (left < share[i]) return last;
      left -= share[i];
    }
    return last;
  }

  /// What stands where a rule puts it, seen by the symbol that it replaces.
  Standing follow(const Standing& from, const Grammar::Successor& to, std::uint64_t key) {
    values_.key = key;
    Vec3 by;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      by[axis] = std::clamp(values_.of(to.move[i], move + i), -tree::longest, tree::longest);
    }
    Standing made{to.which, from.frame, from.size, from.steps + 1, key};
    made.frame.at = from.frame.of(by);
    made.size = std::clamp(from.size * values_.of(to.scale, scale), 0.0, largest);
    made.frame.turn({to.axis, std::clamp(values_.of(to.angle, angle), -1e6, 1e6)});
    return made;
  }

  void finish(const Standing& terminal) {
    if (terminal.size < smallest) {
      ++made_.without_size;
      return;
    }
    see(terminal.frame.at, terminal.size, terminal.steps, terminal.key);
    auto shape = grammar_.terminals[terminal.symbol].shape.shape(values_, shapes);
    if (shape) {
      made_.parts.push_back(placed(*std::move(shape), terminal.frame, terminal.key));
    } else {
      ++made_.without_size;
    }
  }

  const Grammar& grammar_;
  const Axiom& axiom_;
  int deepest_;
  const ResistanceAt& resistance_;
  Values values_;
  std::vector<Standing> open_;
  Derived made_;
};

}  // namespace

Derived derive(const Grammar& grammar, const Axiom& axiom, int deepest,
               const ResistanceAt& resistance) {
  return Derivation(grammar, axiom, deepest, resistance).run();
}

}  // namespace hoodoo::generator
