#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/vector.hpp"

namespace hoodoo::generator {

/// Where a generator looked or began, for people.
struct Mark {
  Vec3 at;
  double value;  // what the list's name says of it
};

/// Two marks of one list that belong together, by their places in it.
struct Edge {
  std::uint32_t from, to;
};

/// What one generator did.
struct Record {
  std::string type, id, where;                                   // its operation in the scene
  std::vector<std::pair<std::string, std::uint64_t>> counts;     // sampled, rejected by ..., placed
  std::vector<std::pair<std::string, std::vector<Mark>>> marks;  // "samples", "sinks", "axioms" ...
  std::vector<std::pair<std::string, std::vector<Edge>>> edges;  // between marks of that list
  std::size_t first_step = 0, steps = 0;                         // of Ground::steps

  void count(std::string_view what, std::uint64_t by = 1);
  std::vector<Mark>& list(std::string_view name);
  std::vector<Edge>& edges_of(std::string_view list);
};

}  // namespace hoodoo::generator
