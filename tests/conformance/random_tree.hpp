#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "engine/tree/node.hpp"
#include "engine/tree/parse.hpp"

/// Random trees for the conformance suite, derived from what the node types list.
namespace hoodoo::tree::conformance {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double real(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
  }
  long long whole(long long low, long long high) {
    return low + static_cast<long long>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  Vec3 place(double far) { return {real(-far, far), real(-far, far), real(-far, far)}; }

 private:
  std::mt19937_64 engine_;
};

inline constexpr double scene_size = 10;  // [m] half the side of what the trees fill

/// A sensible value of a number in `range`: sizes of 1 to 12 m, factors of at most 2, noise that a
/// difference over some centimetres resolves.
inline double random_number(Random& random, const Range& range, std::string_view unit,
                            std::string_view key = "") {
  if (key == "wavelength") return random.real(6, 12);
  if (key == "amplitude") return random.real(0.2, 1.5);
  const double low = unit == "m" ? std::max(range.low, range.low < 0 ? -scene_size : 1.0)
                                 : std::max(range.low, range.open ? 0.1 : -2.0);
  const double high = unit == "m"     ? std::min(range.high, 12.0)
                      : unit == "deg" ? std::min(range.high, 180.0)
                                      : std::min(range.high, 2.0);
  return random.real(unit == "deg" ? std::max(range.low, -180.0) : low, high);
}

template <class T>
void randomise(T& value, Random& random);

template <class T>
void randomise(T& t, const Number<T>& f, Random& random) {
  t.*f.member = random_number(random, f.range, f.unit, f.key);
}
template <class T, class I>
void randomise(T& t, const Whole<T, I>& f, Random& random) {
  t.*f.member = static_cast<I>(random.whole(f.low, f.high > 100 ? f.high : std::min(f.high, 3LL)));
}
template <class T>
void randomise(T& t, const Flag<T>& f, Random& random) {
  t.*f.member = random.whole(0, 1) == 1;
}
template <class T>
void randomise(T& t, const Position<T>& f, Random& random) {
  t.*f.member = random.place(scene_size);
}
template <class T>
void randomise(T& t, const Positions<T>& f, Random& random) {
  auto& points = t.*f.member;
  points.resize(f.least + static_cast<std::size_t>(random.whole(0, 3)));
  for (Point& p : points) p = random.place(scene_size);
}
/// Corners around a place, counter-clockwise.
template <class T>
void randomise(T& t, const Outline<T>& f, Random& random) {
  Polygon& corners = t.*f.member;
  corners.clear();
  const Vec3 middle = random.place(scene_size);
  const auto n = static_cast<int>(f.least) + static_cast<int>(random.whole(0, 3));
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * 3.14159 * (i + random.real(0.1, 0.9)) / n, r = random.real(3, 9);
    corners.push_back({middle.x + r * std::cos(turn), middle.y + r * std::sin(turn)});
  }
}
template <class T>
void randomise(T& t, const BallList<T>& f, Random& random) {
  std::vector<Ball> balls(f.fewest + static_cast<std::size_t>(random.whole(0, 30)));
  for (Ball& b : balls) {
    b = {random.place(scene_size), random.real(1, 4), static_cast<float>(random.real(-2, 2))};
  }
  t.*f.member = Balls(balls);
}
template <class T>
void randomise(T& t, const FileName<T>& f, Random&) {
  t.*f.member = "";
}
template <class T>
void randomise(T& t, const OptionalNumber<T>& f, Random& random) {
  t.*f.member = std::nullopt;
  if (random.whole(0, 1) == 1) t.*f.member = random_number(random, f.range, f.unit, f.key);
}
template <class T>
void randomise(T& t, const Vector<T>& f, Random& random) {
  for (int axis = 0; axis < 3; ++axis) {
    (t.*f.member)[axis] = random_number(random, f.range, f.unit);
    if (f.unit == "1") (t.*f.member)[axis] = random.real(0.5, 2);
  }
}
template <class T>
void randomise(T& t, const Direction<T>& f, Random& random) {
  t.*f.member = random.place(1);
}
template <class T, class E>
void randomise(T& t, const Choice<T, E>& f, Random& random) {
  t.*f.member = static_cast<E>(random.whole(0, static_cast<long long>(f.names.size()) - 1));
}
template <class T, class G>
void randomise(T& t, const Groups<T, G>& f, Random& random) {
  auto& list = t.*f.member;
  list.resize(f.least + static_cast<std::size_t>(random.whole(0, 3)));
  for (G& one : list) randomise(one, random);
}
/// A formula over the coordinates and two parameters.
template <class T>
void randomise(T& t, const Text<T>& f, Random& random) {
  static constexpr std::string_view formulas[] = {
      "a * x / 10 - b",
      "mix(x, y, 0.3) / (4 + abs(z)) + a",
      "clamp(sin(x / 3) * cos(y / 4) + b * z / 10, -1, 1.5)",
      "smoothstep(-8, 8 + a * a, z) * sqrt(x * x + y * y + 1) / 10",
      "exp(-(x * x + y * y) / 40) + log(1 + abs(z)) / (2 + a * a)",
      "pow(x / 10, 3) + pow(1 + abs(y) / 9, a) - pow(z / 12, 2)",
      "max(min(x, y), -z) / 10 + floor(z / 6) * 0.2",
      "noise(x / 9, y / 9, z / 9) - fbm(x / 15, y / 12, z / 20 + b, 3)",
      "fbm(x / 12 + noise(z / 14, y / 14, x / 14), y / 12, z / 12, 2)"};
  t.*f.member = formulas[random.whole(0, static_cast<long long>(std::size(formulas)) - 1)];
}
template <class T>
void randomise(T& t, const Numbers<T>& f, Random& random) {
  t.*f.member = {{"a", random.real(-1, 2)}, {"b", random.real(-1, 1)}};
}
/// Every other roughness is none.
template <class T>
void randomise(T& t, const Group<T, StarTurbulence>& f, Random& random) {
  StarTurbulence& s = t.*f.member;
  randomise(s, random);
  if (random.whole(0, 1) == 0) s.amplitude = 0;
}

template <class T>
void randomise(T& value, Random& random) {
  std::apply([&](const auto&... f) { (randomise(value, f, random), ...); }, T::fields());
}

/// What tests have made, by the name that a node has for it.
inline std::map<std::string, Voxels>& made_voxels() {
  static std::map<std::string, Voxels> made;
  return made;
}
/// So that trees are read back with their voxels.
inline void find_made_voxels(Context& context) {
  context.read_voxels = [](const std::string& file, const std::string&, const std::string&) {
    const auto found = made_voxels().find(file);
    return found == made_voxels().end() ? std::nullopt : std::optional(found->second);
  };
}

/// Some bricks and tiles of some 60 voxels in all directions, turned and stretched.
inline Voxels random_voxels(Random& random) {
  Voxels::Builder builder;
  const auto place = [&](int side) {
    const auto one = [&] { return static_cast<std::int32_t>(random.whole(-2, 1)) * side; };
    return Voxel{one(), one(), one()};
  };
  if (random.whole(0, 3) == 0) {
    builder.tile(place(128), 1, static_cast<float>(random.real(-1, 1)));
  } else {
    builder.tile(place(8), 0, static_cast<float>(random.real(-1, 1)));
  }
  std::array<float, Voxels::brick_size> values;
  for (int bricks = 0; bricks < 12; ++bricks) {
    for (float& v : values) {
      v = random.whole(0, 4) == 0 ? Voxels::unset : static_cast<float>(random.real(-2, 2));
    }
    builder.brick(place(8), values);
  }
  Voxels::Placement placement;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      placement.linear[r][c] = r == c ? random.real(1, 1.5) : random.real(-0.3, 0.3);
    }
  }
  placement.shift = random.place(2);
  return builder.finish(placement, static_cast<float>(random.whole(-1, 1)));
}

/// As a scene would have read it.
inline void randomise(VoxelGrid& grid, Random& random) {
  std::apply([&](const auto&... f) { (randomise(grid, f, random), ...); }, VoxelGrid::fields());
  grid.voxels = random_voxels(random);
  grid.file = "sha256:" + grid.voxels.digest().hex();
  grid.grid.clear();
  made_voxels()[grid.file] = grid.voxels;
}

Node random_tree(Random& random, Family family, int depth);

template <class N>
Node random_node(Random& random, Family family, int depth) {
  N node;
  std::vector<Problem> problems;
  do {
    problems.clear();
    randomise(node, random);
    if constexpr (requires { node.check("", problems); }) node.check("", problems);
  } while (!problems.empty());
  Node tree{node, {}};
  for (const Slot& slot : std::span<const Slot>(N::slots)) {
    const auto most = static_cast<long long>(std::min<std::size_t>(slot.most, slot.list ? 4 : 1));
    const auto least = std::min(most, static_cast<long long>(std::max<std::size_t>(slot.least, 0)));
    const Family inner = slot.family == Family::any ? family : slot.family;
    for (long long n = random.whole(least, most); n > 0; --n) {
      tree.children.push_back(random_tree(random, inner, depth - 1));
    }
  }
  return tree;
}

using Maker = Node (*)(Random&, Family, int);
struct NodeKind {
  std::string_view type;
  Family family;
  bool leaf;
  Maker make;
  bool (*stands)(Family);
};
inline void PrintTo(const NodeKind& kind, std::ostream* out) { *out << kind.type; }

template <class... N>
std::vector<NodeKind> kinds_of(const std::variant<N...>*) {
  return {NodeKind{N::type, N::family, std::span<const Slot>(N::slots).empty(), &random_node<N>,
                   &stands_in<N>}...};
}

/// Every node type, in the order of the variant.
inline const std::vector<NodeKind>& node_kinds() {
  static const std::vector<NodeKind> kinds = kinds_of(static_cast<const AnyNode*>(nullptr));
  return kinds;
}

/// A tree of any node types that may stand in `family`; leaves at depth 0.
inline Node random_tree(Random& random, Family family, int depth) {
  for (;;) {
    const auto& kinds = node_kinds();
    const NodeKind& kind =
        kinds[static_cast<std::size_t>(random.whole(0, static_cast<long long>(kinds.size()) - 1))];
    if (!kind.stands(family)) continue;
    if (depth <= 0 && !kind.leaf) continue;
    return kind.make(random, family, depth);
  }
}

/// Points of a block, in the order of a grid that was shaken: some share x and y.
struct Cloud {
  std::vector<float> x, y, z;
  Cloud(Random& random, const Block& block, std::size_t n) {
    float px = 0, py = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto local = [&](int axis) {
        // Kept inside after rounding to single precision.
        const double low = block.box.min[axis] - block.origin[axis];
        const double high = block.box.max[axis] - block.origin[axis];
        const double margin = 1e-6 * (std::abs(low) + std::abs(high));
        return static_cast<float>(random.real(low + margin, high - margin));
      };
      if (i % 5 == 0) {
        px = local(0);
        py = local(1);
      }
      x.push_back(px);
      y.push_back(py);
      z.push_back(local(2));
    }
  }
  std::size_t size() const { return x.size(); }
  Points points() const { return {x, y, z}; }
  Vec3 at(std::size_t i) const {
    return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
  }
};

/// A random block in or near the scene, up to `side` m wide.
inline Block random_block(Random& random, double side) {
  const Vec3 low = random.place(1.5 * scene_size);
  const double w = random.real(0.05, 1) * side;
  const Vec3 high = low + Vec3{w, w, w};
  return {low, {low, high}};
}

/// A block around all of the scene that shares `block`'s origin: nothing is pruned in it.
inline Block wide_block(const Block& block) {
  return {block.origin, Box{block.origin, block.origin}.grown(1000)};
}

/// As the suites of one test a type are named.
inline std::string name_of(const testing::TestParamInfo<NodeKind>& info) {
  return std::string(info.param.type);
}

}  // namespace hoodoo::tree::conformance
