#pragma once
#include <string>
#include <vector>

namespace hoodoo::scene {

/// The reference of all node types, schema/NODES.md: formula, source, where a type may stand, its
/// children and fields with unit, range and default, and a picture of its example in schema/nodes.
std::string node_reference();

/// The reference of all brushes and generators, schema/TOOLS.md: what each does, its source and its
/// fields with unit, range and default.
std::string tool_reference();

/// A node type, and the families of trees where one may stand: terrain, geology, distance.
struct NodeName {
  std::string type;
  std::vector<std::string> families;
};
std::vector<NodeName> node_names();  // in alphabetical order

}  // namespace hoodoo::scene
