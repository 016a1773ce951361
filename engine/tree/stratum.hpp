#pragma once
#include <optional>
#include <string>
#include <vector>

#include "engine/tree/node.hpp"

namespace hoodoo::tree {

/// Names of the strata in a geology, in its order; one that stands there twice is told twice.
std::vector<std::string> strata_of(const Node& geology);

/// Where the strata called `name` prevail: a tree that is 1/2 or more there. It is the geology less
/// all that does not lead to them, so that what bends and moves space bends and moves them, too.
/// Nothing where there are none, or they are 0 everywhere. Points are fixed.
std::optional<Node> where_prevails(const Node& geology, const std::string& name);

}  // namespace hoodoo::tree
