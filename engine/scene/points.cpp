#include "engine/scene/points.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>
#include <variant>

#include "engine/base/json.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

template <class T, class Field>
void visit_field(const Field&, T&, const std::string&, const VisitPoint&) {}
template <class T>
void visit_field(const tree::Position<T>& f, T& owner, const std::string& where,
                 const VisitPoint& visit) {
  visit(owner.*f.member, fmt::format("{}/{}", where, f.key));
}
template <class T>
void visit_field(const tree::Positions<T>& f, T& owner, const std::string& where,
                 const VisitPoint& visit) {
  auto& points = owner.*f.member;
  for (std::size_t i = 0; i < points.size(); ++i) {
    visit(points[i], fmt::format("{}/{}/{}", where, f.key, i));
  }
}

template <class T, class G>
void visit_field(const tree::Groups<T, G>& f, T& owner, const std::string& where,
                 const VisitPoint& visit);

template <class T>
void visit_fields(T& owner, const std::string& where, const VisitPoint& visit) {
  std::apply([&](const auto&... f) { (visit_field(f, owner, where, visit), ...); }, T::fields());
}

template <class T, class G>
void visit_field(const tree::Groups<T, G>& f, T& owner, const std::string& where,
                 const VisitPoint& visit) {
  auto& list = owner.*f.member;
  for (std::size_t i = 0; i < list.size(); ++i) {
    visit_fields(list[i], fmt::format("{}/{}/{}", where, f.key, i), visit);
  }
}

std::span<const tree::Slot> slots_of(const tree::AnyNode& node) {
  return std::visit(
      [](const auto& n) {
        return std::span<const tree::Slot>(std::remove_cvref_t<decltype(n)>::slots);
      },
      node);
}

}  // namespace

void visit_points(tree::Node& node, const json& at, const std::string& where,
                  const tree::Context& context, const VisitPoint& visit) {
  if (const auto use = at.find("use"); use != at.end()) {
    const auto& definition = context.definitions.at(use->get<std::string>());
    visit_points(node, *definition.json, definition.where, context, visit);
    return;
  }
  std::visit([&](auto& n) { visit_fields(n, where, visit); }, node.value);
  std::size_t next = 0;
  for (const auto& slot : slots_of(node.value)) {
    const auto found = at.find(slot.key);
    if (found == at.end()) continue;
    const auto below = fmt::format("{}/{}", where, slot.key);
    if (!slot.list) {
      visit_points(node.children.at(next++), *found, below, context, visit);
      continue;
    }
    for (std::size_t i = 0; i < found->size(); ++i) {
      visit_points(node.children.at(next++), (*found)[i], fmt::format("{}/{}", below, i), context,
                   visit);
    }
  }
}

void visit_points(AnyTool& tool, const std::string& where, const VisitPoint& visit) {
  std::visit([&](auto& one) { visit_fields(one, where, visit); }, tool);
}

std::optional<double> InputTerrain::height(double x, double y) const {
  const Box here{{x, y, 0}, {x, y, 0}};
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto& domain = bodies_[i].domain;
    if (!domain.empty() && tree::edge_distance(domain, x, y).d < 0) continue;
    const auto extent = pyramids_[i]->extent();
    if (extent.empty() || x < extent.min.x || x > extent.max.x || y < extent.min.y ||
        y > extent.max.y) {
      continue;
    }
    const auto window = pyramids_[i]->window(0, here);
    if (!window.empty() && window.valid(x, y)) return window.height(x, y) + bodies_[i].offset;
  }
  return std::nullopt;
}

std::optional<std::string> InputTerrain::fix(tree::Point& point) const {
  using Form = tree::Point::Form;
  if (point.form == Form::fixed) return std::nullopt;
  Vec3 at = point.value;
  if (point.form == Form::ground_uv) {
    const auto extent = pyramids_.front()->extent();
    at.x = extent.min.x + at.x * (extent.max.x - extent.min.x);
    at.y = extent.min.y + at.y * (extent.max.y - extent.min.y);
  }
  const auto ground = height(at.x, at.y);
  if (!ground) {
    return fmt::format("no terrain has an elevation at x = {:.2f} m, y = {:.2f} m", at.x, at.y);
  }
  point = Vec3{at.x, at.y, *ground + at.z};
  return std::nullopt;
}

}  // namespace hoodoo::scene
