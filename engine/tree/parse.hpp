#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::tree {

/// What one scene's trees share while they are read.
struct Context {
  /// "define": name -> its JSON and the JSON Pointer of it. What it points at outlives the context.
  struct Definition {
    const nlohmann::json* json;
    std::string where;
  };
  std::map<std::string, Definition, std::less<>> definitions;
  std::size_t nodes_left = 1'000'000;  // instances count as often as they are used
  int deepest = 64;                    // nesting of nodes, instances included
  std::vector<Problem> warnings;       // oddities that are no errors
  /// Reads a grid of a file for the node at `where` and reports its problems by itself. Where there
  /// is no such function, or it gives none, nodes stay without voxels.
  std::function<std::optional<Voxels>(const std::string& file, const std::string& grid,
                                      const std::string& where)>
      read_voxels;

  /// Checks the file of balls of the node at `where`, reports its problems by itself and gives the
  /// least radius [m] in it. Where there is no such function, files are not looked at.
  std::function<std::optional<double>(const std::string& file, const std::string& where)>
      check_balls;

  /// A definition as it was read the first time; none where that failed.
  struct Instance {
    std::optional<Node> tree;
    std::size_t nodes = 0;
    int depth = 0;
  };
  std::map<std::pair<Family, std::string>, Instance> read;
  std::vector<std::string> open;  // names of the instances around the node being read
  int depth = 0;
  bool stopped = false;  // a limit was broken and reported
};

/// Reads one node with all below it, expanding `{"use": name}`. `where` is the JSON Pointer of
/// `json`. Every problem is added to `problems`: unknown keys (naming the nearest known one),
/// missing ones, wrong types, numbers out of range with unit and range, an unknown type, a type
/// that does not belong into a tree of this family, a cycle of `use` (naming the chain), too many
/// nodes. A definition's own problems are reported once, however often it is used.
/// Nothing is returned only if the node itself could not be made; a node with problems
/// below it is returned without them.
std::optional<Node> parse_node(const nlohmann::json& json, const std::string& where, Family family,
                               Context& context, std::vector<Problem>& problems);

/// Canonical form: every field present, instances expanded. parse_node gives the same node back.
nlohmann::json to_json(const Node& node);

/// JSON Schema (draft 2020-12) "$defs": one per node type ("node.sphere"), "terrain_node",
/// "geology_node" and "distance_node" for any of a family, "any_node" where that is not known yet,
/// "use", "point". Derived from the fields.
nlohmann::json node_schema();

}  // namespace hoodoo::tree
