#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/generator/stated_tree.hpp"
#include "engine/tree/formula.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::generator {

/// What formulas may name, and values at which they are tried when they are read.
struct Names {
  std::vector<std::string> variables;
  std::vector<double> typical;
};

/// A formula; a number is one without a name.
std::optional<tree::Program> read_formula(const nlohmann::json& json, const std::string& where,
                                          const Names& names, std::vector<Problem>& problems);

/// Values of a formula's names: `u` is drawn anew for each formula, by its number.
struct Values {
  std::vector<double> variables;  // u is the first
  Vec3 at;                        // x, y, z [m]
  std::uint64_t key = 0;          // what u is drawn from

  double of(const tree::Program& formula, std::uint64_t number);
};

/// A tree some of whose numbers are formulas.
class ShapeTemplate {
 public:
  /// Reads a node whose numbers, coordinates of vectors and points, and numbers of groups may be
  /// formulas. `json` is read by `read` with a number in each formula's place.
  static std::optional<ShapeTemplate> read(nlohmann::json json, const std::string& where,
                                           const Names& names, const ReadTree& read,
                                           std::vector<Problem>& problems);

  /// The tree for these values; `first` numbers its first formula. None where a number comes out of
  /// its range, or the numbers contradict each other.
  std::optional<tree::Node> shape(Values& values, std::uint64_t first) const;

  using Put = std::function<bool(tree::AnyNode&, double)>;  // false: out of range
  struct Filled {
    std::vector<std::size_t> path;  // children on the way from the root
    tree::Program formula;
    Put put;
  };

 private:
  tree::Node tree_;
  std::vector<Filled> filled_;
  bool checked_ = false;  // some node has rules between its numbers
};

}  // namespace hoodoo::generator
