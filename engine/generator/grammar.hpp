#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/generator/shape_template.hpp"
#include "engine/generator/stated_tree.hpp"

namespace hoodoo::generator {

/// An open parameterised grammar: symbols at a place, of a size, in a turned frame, are replaced by
/// others until only terminals, trees of nodes, are left.
///
///     {"axiom": "A",
///      "parameters": {"taper": 0.9},
///      "rules": [
///        {"symbol": "A", "to": ["foot", {"symbol": "B", "move": [0, 0, "s"]}]},
///        {"symbol": "B", "probability": "1 - rho", "to": ["cap"]},
///        {"symbol": "B", "to": ["neck", {"symbol": "B", "move": [0, 0, "s"], "scale": "taper",
///                                        "rotate": {"axis": [0, 0, 1], "angle": "360 * u"}}]}],
///      "terminals": {"cap": {"type": "sphere", "center": [0, 0, 0], "radius": "s * (1 + rho)"},
///      ...}}
///
/// Formulas (engine/tree/formula.hpp) may name s, the symbol's size [m]; rho, the resistance at its
/// place; h, its height above the axiom [m]; n, the steps of derivation to it; u, a random number
/// in [0, 1) of this formula's own; slope, the rise over run of the ground at the axiom; x, y, z
/// [m]; and the parameters. Those of probabilities, moves, scales and turns see the symbol that is
/// replaced, those of a terminal's tree see the terminal itself.
///
/// One of a symbol's rules is taken, each with its probability over the sum of all; one that states
/// none has an equal share of what the others leave of 1. `move` [m] is along the axes of the
/// symbol's frame, `scale` a factor on its size, `rotate` turns the frame of what follows.
/// Source: Paris et al. 2019, section 6.3 and figure 21; Mech and Prusinkiewicz 1996.
struct Grammar {
  struct Successor {
    bool terminal = false;
    std::size_t which = 0;                // of `terminals` or `symbols`
    std::array<tree::Program, 3> move{};  // [m]
    tree::Program scale, angle;           // [1], [deg]
    Vec3 axis{0, 0, 1};
  };
  struct Rule {
    std::optional<tree::Program> probability;
    std::vector<Successor> to;
  };
  struct Symbol {
    std::string name;
    std::vector<Rule> rules;
  };
  struct Terminal {
    std::string name;
    ShapeTemplate shape;
  };
  std::vector<Symbol> symbols;
  std::vector<Terminal> terminals;
  std::size_t axiom = 0;
  std::vector<std::string> parameters;  // names, in the order of `values`
  std::vector<double> values;           // of the parameters

  /// The value of a parameter; none where there is no such.
  double* parameter(std::string_view name);
};

/// Reads a grammar. Every problem is added to `problems` with its pointer: unknown keys, names of
/// neither a symbol nor a terminal, symbols that no rule replaces, symbols whose derivation can
/// never end, formulas that are none, and what `read` finds in the trees of terminals.
std::optional<Grammar> read_grammar(const nlohmann::json& json, const std::string& where,
                                    const ReadTree& read, std::vector<Problem>& problems);
/// JSON Schema of a grammar.
nlohmann::json grammar_schema();

/// Where a derivation begins.
struct Axiom {
  Vec3 at;                     // [m]
  double size = 1;             // s [m]
  double slope = 0;            // of the ground, rise over run
  std::uint64_t key = 0;       // everything random is drawn from it
  std::vector<double> values;  // of the parameters; none: the grammar's own
};

/// A symbol's place may be asked for any number of times.
using ResistanceAt = std::function<double(const Vec3&)>;

struct Derived {
  std::vector<tree::Node> parts;  // terminals where they stand, in the order of the rules
  std::size_t symbols = 0;        // replaced
  std::size_t too_deep = 0;       // left out: `deepest` steps from the axiom
  std::size_t too_many = 0;       // left out: one more than most_symbols
  std::size_t without_size = 0;   // terminals one of whose numbers came out of its range
  std::size_t dead_ends = 0;      // symbols none of whose rules had a probability
};

inline constexpr std::size_t most_symbols = 10'000;  // of one axiom
inline constexpr int deepest_derivation = 1000;

/// Derives one axiom. A function of its arguments alone.
Derived derive(const Grammar& grammar, const Axiom& axiom, int deepest,
               const ResistanceAt& resistance);

}  // namespace hoodoo::generator
