#include "engine/tree/stratum.hpp"

#include <utility>
#include <variant>

namespace hoodoo::tree {
namespace {

void add_names(const Node& tree, std::vector<std::string>& names) {
  if (const auto* stratum = std::get_if<Stratum>(&tree.value)) names.push_back(stratum->name);
  for (const Node& child : tree.children) add_names(child, names);
}

/// `child` in units of which its prevailing part has 1/2 or more.
std::optional<Node> prevailing(const Stratum& stratum, const Node& child) {
  const Interval range = support(child).range;
  const double peak = range.high >= -range.low ? range.high : range.low;
  if (peak == 0) return std::nullopt;
  return Node{Blend{0.5 / (stratum.level * peak)}, {child}};
}

/// Whether a node shows its first child elsewhere: what else it holds says where, and how far.
bool bends_first(const Node& tree) {
  return std::visit(
      [](const auto& node) {
        using N = std::remove_cvref_t<decltype(node)>;
        if constexpr (Combiner<N> || N::slots.size() == 0) {
          return false;
        } else {
          return N::slots[0].key == "child";
        }
      },
      tree.value);
}

}  // namespace

std::vector<std::string> strata_of(const Node& geology) {
  std::vector<std::string> names;
  add_names(geology, names);
  return names;
}

std::optional<Node> where_prevails(const Node& geology, const std::string& name) {
  if (const auto* stratum = std::get_if<Stratum>(&geology.value);
      stratum && stratum->name == name) {
    return prevailing(*stratum, geology.children[0]);
  }
  if (geology.children.empty()) return std::nullopt;
  if (bends_first(geology)) {
    auto child = where_prevails(geology.children[0], name);
    if (!child) return std::nullopt;
    Node bent = geology;
    bent.children[0] = std::move(*child);
    return bent;
  }
  Node any{Union{}, {}};
  for (const Node& child : geology.children) {
    if (auto part = where_prevails(child, name)) any.children.push_back(std::move(*part));
  }
  if (any.children.empty()) return std::nullopt;
  return any.children.size() == 1 ? std::move(any.children[0]) : std::move(any);
}

}  // namespace hoodoo::tree
