#include "engine/scene/copies.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/placement.hpp"
#include "engine/scene/points.hpp"

namespace hoodoo::scene {
namespace {

/// What is drawn for a variant, by number.
enum Draw : std::uint64_t { distance = 1, direction = 2, turn = 3, size = 4, roughness = 5 };

/// A place on the input terrain.
std::optional<Vec3> on_ground(const InputTerrain& terrain, double x, double y) {
  tree::Point point(tree::Point::Form::ground_xy, {x, y, 0});
  if (terrain.fix(point)) return std::nullopt;
  return point.value;
}

/// The ground in the middle of what a tree makes.
Vec3 foot_of(const tree::Node& tree, const InputTerrain& terrain, const std::string& where) {
  const Box box = tree::support(tree).influence;
  const Vec3 middle = (box.min + box.max) * 0.5;
  if (box.empty() || !std::isfinite(middle.x) || !std::isfinite(middle.y)) {
    throw Error(Fault::bad_input, where,
                "needs a tree that ends somewhere: this one has no middle");
  }
  const auto foot = on_ground(terrain, middle.x, middle.y);
  if (foot) return *foot;
  throw Error(Fault::bad_input, where,
              fmt::format("needs ground below: no terrain has an elevation at x = {:.2f} m, y = "
                          "{:.2f} m",
                          middle.x, middle.y));
}

/// Turned about the upright through `foot` and scaled about it, then moved to another place.
generator::Placement placement_of(const VariantSettings& variants, std::uint64_t key,
                                  const Vec3& foot, const Vec3& to) {
  const auto real = [&](Draw what) { return unit_real(random_bits(key, what)); };
  generator::Placement placement;
  placement.turn({{0, 0, 1}, variants.rotation * (2 * real(turn) - 1)});
  placement.scale =
      variants.least_scale + (variants.most_scale - variants.least_scale) * real(size);
  placement.at = to - placement.of(foot);
  return placement;
}

std::vector<tree::Node> variants_of(const Rebuild& build, const VariantSettings& variants,
                                    std::uint64_t seed, const Vec3& foot,
                                    const InputTerrain& terrain) {
  std::vector<tree::Node> made;
  for (int i = 0; i < variants.count; ++i) {
    const auto key = random_bits(seed, variants.seed, i);
    const double away = variants.spread * std::sqrt(unit_real(random_bits(key, distance)));
    const double angle = 2 * pi * unit_real(random_bits(key, direction));
    const auto to =
        on_ground(terrain, foot.x + away * bit_cos(angle), foot.y + away * bit_sin(angle));
    if (!to) continue;
    const auto own = random_bits(key, roughness) | 1;  // not 0, which is the seed as stated
    made.push_back(generator::placed(build(own), placement_of(variants, key, foot, *to), own));
  }
  return made;
}

tree::Node mirrored(const MirrorSettings& mirror, tree::Node tree) {
  const double along = mirror.angle * (pi / 180);
  tree::Mirror image;
  image.point = Vec3{mirror.point[0], mirror.point[1], 0};
  image.normal = {-bit_sin(along), bit_cos(along), 0};
  return {image, {std::move(tree)}};
}

}  // namespace

void VariantSettings::check(const std::string& where, std::vector<Problem>& problems) const {
  if (least_scale <= most_scale) return;
  problems.push_back(
      {where + "/most_scale",
       fmt::format("must be at least \"least_scale\", {}, got {}", least_scale, most_scale)});
}

tree::Node with_copies(const Rebuild& build, const Copies& copies, std::uint64_t seed,
                       const InputTerrain& terrain, const std::string& where,
                       std::vector<std::string>& warnings) {
  tree::Node own = build(0);
  if (copies.variants) {
    const Vec3 foot = foot_of(own, terrain, where + "/variants");
    auto all = variants_of(build, *copies.variants, seed, foot, terrain);
    const auto missing = static_cast<std::size_t>(copies.variants->count) - all.size();
    if (missing > 0) {
      warnings.push_back(
          fmt::format("{}/variants: {} of {} would stand over no ground and are left "
                      "out",
                      where, missing, copies.variants->count));
    }
    all.insert(all.begin(), std::move(own));
    own = generator::united(std::move(all));
  }
  if (copies.mirror) {
    auto image = mirrored(*copies.mirror, own);
    own = generator::united({std::move(own), std::move(image)});
  }
  return own;
}

}  // namespace hoodoo::scene
