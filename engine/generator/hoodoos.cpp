#include "engine/generator/hoodoos.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "engine/base/random.hpp"
#include "engine/generator/disk_samples.hpp"
#include "engine/generator/placement.hpp"
#include "engine/tree/evaluate.hpp"
#include "engine/tree/parse.hpp"

namespace hoodoo::generator {
namespace {

/// Hoodoos of a square of this side read the same compiled geology.
constexpr double square_side = 32;  // [m]
/// What is drawn for a hoodoo, by number.
enum Draw : std::uint64_t { keep = 1, size = 2, height = 3, derivation = 4, crease_noise = 5 };
/// Ground steeper than this does not lower the foot further.
constexpr double steepest_foot = 2;  // rise over run

/// The geology alone around one square of the plane.
class Rock {
 public:
  Rock(const tree::Ground& ground, const Vec3& origin)
      : ground_(ground), origin_(origin), box_{origin, origin} {}

  double at(const Vec3& p) {
    if (!ground_.geology) return 0.5;
    if (!box_.contains(p)) enclose(p);
    if (!compiled_.kernel) return 0;
    const Vec3 d = p - origin_;
    const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y),
               z = static_cast<float>(d.z);
    float rho = 0;
    compiled_.kernel->values({{&x, 1}, {&y, 1}, {&z, 1}}, {&rho, 1});
    return std::clamp(static_cast<double>(rho), 0.0, 1.0);
  }

 private:
  /// What is compiled for a box gives the same bits as for any other.
  void enclose(const Vec3& p) {
    box_.add(p);
    box_ = box_.grown(square_side);
    compiled_ = tree::compile(*ground_.geology, {origin_, box_});
  }
  const tree::Ground& ground_;
  Vec3 origin_;
  Box box_;
  tree::Compiled compiled_;
};

/// A body's value at one place.
float value_at(const tree::Compiled& body, const Vec3& origin, const Vec3& p) {
  if (!body.kernel) return 0;
  const Vec3 d = p - origin;
  const auto x = static_cast<float>(d.x), y = static_cast<float>(d.y), z = static_cast<float>(d.z);
  float f = 0;
  body.kernel->values({{&x, 1}, {&y, 1}, {&z, 1}}, {&f, 1});
  return f;
}

/// Whether the body holds the ground at its middle or around it.
bool is_rooted(const tree::Node& body, const Vec3& foot, double radius) {
  const auto compiled = tree::compile(body, {foot, Box{foot, foot}.grown(radius)});
  constexpr std::array<std::array<double, 2>, 5> around{
      {{0, 0}, {0.5, 0}, {-0.5, 0}, {0, 0.5}, {0, -0.5}}};
  return std::ranges::any_of(around, [&](const auto& d) {
    return value_at(compiled, foot, foot + Vec3{d[0] * radius, d[1] * radius, 0}) >= 0.5F;
  });
}

struct Planted {
  DiskSample sample;
  double chance;
  Footing foot;
};

/// A hoodoo, and what became of its symbols.
struct Grown {
  std::optional<tree::Node> body;
  std::size_t parts = 0, symbols = 0, too_deep = 0, too_many = 0, without_size = 0, dead_ends = 0;
  bool rootless = false;
};

tree::Node joined(std::vector<tree::Node> parts, double smoothness) {
  if (parts.size() == 1) return std::move(parts.front());
  if (smoothness == 0) return {tree::Union{}, std::move(parts)};
  tree::SmoothUnion join;
  join.width = smoothness;
  return {join, std::move(parts)};
}

/// One generator at work.
class Planting {
 public:
  Planting(const Hoodoos& hoodoos, Growth& growth) : hoodoos_(hoodoos), growth_(growth) {}

  std::vector<Planted> axioms() const {
    const Box box = growth_.reach();
    if (!(box.min.x <= box.max.x && box.min.y <= box.max.y)) return {};
    const HabitatMap map(growth_.site, hoodoos_, box);
    const double near = hoodoos_.distance, far = hoodoos_.sparse_distance.value_or(near);
    const auto chance = [&](double x, double y) {
      return hoodoos_.probability * map.suitability(x, y);
    };
    DiskSampling sampling{box, near, far, growth_.seed, {}, {}};
    if (far > near) {
      sampling.distance = [&](double x, double y) {
        return far + (near - far) * map.suitability(x, y);
      };
    }
    sampling.wanted = [&](double x, double y, std::uint64_t key) {
      return unit_real(random_bits(key, keep)) < chance(x, y);
    };
    std::vector<Planted> all;
    std::vector<Vec3> at;
    for (const auto& sample : sample_disks(growth_.site, sampling)) {
      all.push_back({sample, chance(sample.x, sample.y), {}});
      at.push_back({sample.x, sample.y, 0});
    }
    const auto feet = footings(growth_.site, at);
    for (std::size_t i = 0; i < all.size(); ++i) all[i].foot = feet[i];
    growth_.record.count("sampled", all.size());
    rejected("off the ground", std::erase_if(all, [](const auto& p) { return !p.foot.found; }));
    rejected("outside the region", std::erase_if(all, [&](const Planted& p) {
               return unit_real(random_bits(p.sample.key, keep)) >=
                      p.chance * growth_.weight(p.foot.at);
             }));
    return all;
  }

  std::vector<Grown> grown(const std::vector<Planted>& axioms) const {
    const auto square = [&](std::size_t i) {
      return std::pair(std::floor(axioms[i].foot.at.x / square_side),
                       std::floor(axioms[i].foot.at.y / square_side));
    };
    std::vector<std::size_t> order(axioms.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, square);
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i == 0 || square(order[i]) != square(order[i - 1])) starts.push_back(i);
    }
    starts.push_back(order.size());
    std::vector<Grown> made(axioms.size());
    growth_.site.in_parallel(starts.size() - 1, [&](std::size_t r) {
      const auto [x, y] = square(order[starts[r]]);
      Rock rock(growth_.site.ground(), {x * square_side, y * square_side, 0});
      for (auto i = starts[r]; i < starts[r + 1]; ++i) {
        made[order[i]] = grow_one(axioms[order[i]], rock);
      }
    });
    return made;
  }

 private:
  void rejected(std::string_view why, std::size_t count) const {
    if (count > 0) growth_.record.count(why, count);
  }

  /// 1 with the variation either way.
  double varied(std::uint64_t key, Draw what) const {
    return 1 + hoodoos_.variation * (2 * unit_real(random_bits(key, what)) - 1);
  }

  Grown grow_one(const Planted& planted, Rock& rock) const {
    const auto key = planted.sample.key;
    auto grammar_values = hoodoos_.grammar.values;
    const auto value = [&](std::string_view name) -> double* {
      const auto& names = hoodoos_.grammar.parameters;
      const auto found = std::ranges::find(names, name);
      return found == names.end()
                 ? nullptr
                 : &grammar_values[static_cast<std::size_t>(found - names.begin())];
    };
    const double bigger = varied(key, size);
    auto *radius = value("radius"), *tall = value("height");
    Axiom axiom;
    axiom.size = (radius != nullptr ? *radius : hoodoos_.radius.value_or(1)) * bigger;
    const double below = hoodoos_.sink + std::min(planted.foot.slope, steepest_foot) * axiom.size;
    if (radius != nullptr) *radius = axiom.size;
    if (tall != nullptr) *tall = *tall * bigger * varied(key, height) + below;
    axiom.at = planted.foot.at - Vec3{0, 0, below};
    axiom.slope = planted.foot.slope;
    axiom.key = random_bits(key, derivation);
    axiom.values = std::move(grammar_values);
    auto derived =
        derive(hoodoos_.grammar, axiom, hoodoos_.depth, [&](const Vec3& p) { return rock.at(p); });
    Grown made;
    made.parts = derived.parts.size();
    made.symbols = derived.symbols;
    made.too_deep = derived.too_deep;
    made.too_many = derived.too_many;
    made.without_size = derived.without_size;
    made.dead_ends = derived.dead_ends;
    if (derived.parts.empty()) return made;
    auto body = joined(std::move(derived.parts), hoodoos_.smoothness);
    made.rootless = !is_rooted(body, planted.foot.at, axiom.size);
    if (!made.rootless) made.body = std::move(body);
    return made;
  }

  const Hoodoos& hoodoos_;
  Growth& growth_;
};

tree::Node creased(tree::Node tree, const Hoodoos& hoodoos, std::uint64_t seed) {
  if (hoodoos.crease == 0) return tree;
  tree::Warp warp;
  warp.amplitude = hoodoos.crease;
  warp.wavelength = hoodoos.crease_wavelength;
  warp.seed = static_cast<std::uint32_t>(random_bits(seed, crease_noise));
  return {warp, {std::move(tree)}};
}

}  // namespace

void Hoodoos::check(const std::string& where, std::vector<Problem>& problems) const {
  if (sparse_distance && *sparse_distance < distance) {
    problems.push_back(
        {where + "/sparse_distance",
         fmt::format("must be at least \"distance\", {} m, got {}", distance, *sparse_distance)});
  }
  if (sparse_distance && *sparse_distance > 20 * distance) {
    problems.push_back({where + "/sparse_distance",
                        fmt::format("must be at most 20 times \"distance\", {} m, got {}", distance,
                                    *sparse_distance)});
  }
}

void Hoodoos::read_trees(const std::string& where, const ReadTree& read,
                         std::vector<Problem>& problems) {
  if (stated.given()) {
    auto made = read_grammar(stated.json, stated.where, read, problems);
    if (!made) return;
    grammar = *std::move(made);
  } else {
    tree::Context context;
    std::vector<Problem> own;
    const ReadTree plain = [&](const nlohmann::json& json, const std::string& at) {
      return tree::parse_node(json, at, tree::Family::terrain, context, own);
    };
    auto made = read_grammar(nlohmann::json::parse(preset_grammar(preset)), "", plain, own);
    if (!made) {
      throw Error(Fault::internal, own.empty() ? "" : own[0].where,
                  own.empty() ? "a preset is no grammar" : own[0].what);
    }
    grammar = *std::move(made);
  }
  const auto set = [&](std::string_view name, const std::optional<double>& value) {
    if (!value) return;
    if (auto* parameter = grammar.parameter(name)) {
      *parameter = *value;
    } else if (name != "radius") {
      problems.push_back(
          {fmt::format("{}/{}", where, name),
           fmt::format("is no parameter of the grammar: it has none named \"{}\"", name)});
    }
  };
  set("height", height);
  set("radius", radius);
  set("cap", cap);
  set("waist", waist);
}

void Hoodoos::grow(Growth& growth) const {
  const Planting planting(*this, growth);
  const auto axioms = planting.axioms();
  expect_few(axioms.size(), most_primitives, "hoodoos");
  auto grown = planting.grown(axioms);
  auto& marks = growth.record.list("axioms");
  for (const auto& axiom : axioms) marks.push_back({axiom.foot.at, axiom.chance});
  Grown sum;
  std::size_t rootless = 0;
  std::vector<tree::Node> bodies;
  for (auto& one : grown) {
    sum.symbols += one.symbols;
    sum.too_deep += one.too_deep;
    sum.too_many += one.too_many;
    sum.without_size += one.without_size;
    sum.dead_ends += one.dead_ends;
    rootless += one.rootless ? 1 : 0;
    if (!one.body) continue;
    sum.parts += one.parts;
    bodies.push_back(*std::move(one.body));
  }
  auto& record = growth.record;
  record.count("symbols", sum.symbols);
  for (const auto& [what, count] : {std::pair("symbols too deep", sum.too_deep),
                                    {"symbols too many", sum.too_many},
                                    {"symbols without a rule", sum.dead_ends},
                                    {"terminals without a size", sum.without_size},
                                    {"without a foot in the ground", rootless}}) {
    if (count > 0) record.count(what, count);
  }
  record.count("terminals", sum.parts);
  record.count("placed", bodies.size());
  expect_few(sum.parts, most_primitives, "terminals");
  if (bodies.empty()) return;
  growth.add(op, creased(united(std::move(bodies)), *this, growth.seed));
}

namespace form {
nlohmann::json grammar_schema() { return generator::grammar_schema(); }
}  // namespace form

}  // namespace hoodoo::generator
