#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/hash.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::tree {

/// One rock, and what an engine needs to know of it.
struct Material {
  std::string name;
  std::array<std::uint8_t, 3> color;  // sRGB
  double low, high;                   // resistance range [1], half-open, the last one closed
  double friction;                    // [1]
  std::string stratum = "";           // the one it is bound to; then its range is not looked up
};

/// A body given by elevations: the height field, cut by a prism where it has a domain.
/// F_T = (1 + s(v / falloff)) / 2, s(u) = (3u - u^3)/2 on u clamped to [-1, 1], v = h(x,y) - z
/// (Paris et al. 2019, section 5.1, as DESIGN section 3 normalises it).
struct HeightBody {
  std::string id;
  double falloff;                             // R [m], > 0
  bool slope_corrected = false;               // v divided by sqrt(1 + |grad h|^2)
  bool inverted = false;                      // solid above the elevations
  double offset = 0;                          // [m], added to the elevations
  std::vector<std::array<double, 2>> domain;  // polygon [m]; empty: no prism
};

/// `replace`: the tree in place of what is there. It is what generators make (smooth.hpp), whose
/// tree covers the region, so that nothing is cut off at the tree's end.
enum class Operation { blend, carve, unite, difference, intersect, replace };

/// Whether a tree that is 0 changes something.
constexpr bool acts_by_zero(Operation operation) {
  return operation == Operation::intersect || operation == Operation::replace;
}

/// Where an operation acts: its result is mixed in with a weight that falls from 1 to 0 across
/// `feather` metres centred on the region's edge.
struct Region;  // engine/tree/region.hpp

/// One step of the queue.
struct Step {
  std::string id;     // "" when the scene gives none
  std::string where;  // JSON Pointer of its operation
  Operation operation;
  Node tree;
  std::shared_ptr<const Region> region;  // null: everywhere
  int material = -1;                     // index into Ground::materials; -1: by resistance
};

/// Rock bound to a named stratum of the geology.
struct Seam {
  int material;  // index into Ground::materials
  Node tree;     // 1/2 or more where the stratum prevails
};

/// The whole implicit world: bodies united, then the steps in order, each result clamped to [0,1];
/// beside it the geology. All points resolved, in metres in the scene frame.
struct Ground {
  std::vector<HeightBody> bodies;
  std::vector<Step> steps;
  std::optional<Node> geology;      // none: rho = 1/2 everywhere
  std::vector<Seam> seams;          // the first that holds a point names its material; without
                                    // one its resistance does
  std::vector<Material> materials;  // never empty
};

/// What of `ground` can matter inside `reach`: steps whose influence misses it are dropped, and
/// inside sums the children that do. Features thinner than `thinnest` [m] are left out.
Ground prune(const Ground& ground, const Box& reach, double thinnest);

/// Box outside which the steps change nothing.
Box influence(const Ground& ground);

/// The same but for lists of balls, which are emptied; their digests follow each other in `lists`.
Ground without_balls(Ground ground, std::vector<Digest>& lists);

/// Canonical form: every value present, keys sorted. Equal grounds give equal text.
nlohmann::json to_json(const Ground& ground);

}  // namespace hoodoo::tree
