#include "engine/generator/island.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "engine/base/error.hpp"

namespace hoodoo::generator {
namespace {

/// How far out a place is: 0 in the middle, 1 on the outline. Noise only ever adds, so that the
/// outline lies in the circle.
constexpr const char* out =
    "(sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy)) / r"
    " + 0.42 * fbm((x - cx) / r, (y - cy) / r, 3.5, 4))";
/// Hills that come down to the rim.
constexpr const char* hills =
    "relief * max(0, 1.7 * fbm((x - cx) / (0.9 * r), (y - cy) / (0.9 * r), 8.5, 5) - 0.4)"
    " * (1 - smoothstep(0.3, 0.95, sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy)) / r))";
/// A cone that tapers off, torn into spikes.
constexpr const char* spikes =
    "0 - rim - depth * pow(max(0, 1 - {}), 1.3)"
    " * (0.35 + 1.3 * fbm((x - cx) / (0.4 * r), (y - cy) / (0.4 * r), 13.5, 4))";
constexpr double deepest = 1.65, highest = 1.3;  // of these, in depths and reliefs

tree::Parameters parameters(const Vec3& middle, const Island::Size& size) {
  return {{"cx", middle.x},        {"cy", middle.y},  {"cz", middle.z},      {"r", size.radius},
          {"relief", size.relief}, {"rim", size.rim}, {"depth", size.depth}, {"f", size.falloff}};
}

std::string bottom_formula() { return fmt::format(fmt::runtime(spikes), out); }
std::string inside_formula() { return fmt::format("r * (1 - {})", out); }

tree::Program program(const std::string& formula, const tree::Parameters& values) {
  auto parsed = tree::parse_formula(formula, values);
  if (const auto* error = std::get_if<tree::FormulaError>(&parsed)) {
    throw Error(Fault::internal, "", "an island's formula: " + error->what);
  }
  return std::get<tree::Program>(std::move(parsed));
}

}  // namespace

Island::Island(const Vec3& middle, const Size& size, std::uint64_t key)
    : middle_(middle), size_(size), seed_(static_cast<std::uint32_t>(key)) {
  const auto values = parameters(middle, size);
  top_ = program(hills, values);
  bottom_ = program(bottom_formula(), values);
  inside_ = program(inside_formula(), values);
}

double Island::value(const tree::Program& program, double x, double y) const {
  return tree::evaluate(program, {x, y, 0}, {}, seed_);
}
double Island::top(double x, double y) const { return middle_.z + value(top_, x, y); }
double Island::bottom(double x, double y) const { return middle_.z + value(bottom_, x, y); }
double Island::inside(double x, double y) const { return value(inside_, x, y); }
double Island::depth(const Vec3& p) const {
  return std::min({top(p.x, p.y) - p.z, p.z - bottom(p.x, p.y), inside(p.x, p.y)});
}

Box Island::box() const {
  const Vec3 wide{size_.radius, size_.radius, 0};
  return {middle_ - wide - Vec3{0, 0, size_.rim + deepest * size_.depth},
          middle_ + wide + Vec3{0, 0, highest * size_.relief}};
}

tree::Node Island::around() const {
  const Box all = box();
  tree::Cylinder cylinder;
  cylinder.falloff = size_.falloff;
  cylinder.radius = size_.radius + size_.falloff;
  cylinder.base = Vec3{middle_.x, middle_.y, all.min.z - size_.falloff};
  cylinder.top = Vec3{middle_.x, middle_.y, all.max.z + size_.falloff};
  return {cylinder, {}};
}

tree::Node Island::tree() const {
  const auto values = parameters(middle_, size_);
  // Held to [0, 1], of which the intersection knows that it ends where the cylinder does; bounds of
  // a formula alone are rounded outward.
  const auto side = [&](const std::string& v) -> tree::Node {
    tree::Expression field;
    field.formula = fmt::format("smoothstep(-f, f, {})", v);
    field.parameters = values;
    field.seed = seed_;
    return {tree::Clamp{}, {{std::move(field), {}}}};
  };
  return {tree::Intersection{},
          {around(), side(fmt::format("cz + {} - z", hills)),
           side(fmt::format("z - cz - ({})", bottom_formula())), side(inside_formula())}};
}

}  // namespace hoodoo::generator
