#include "engine/tree/parse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>

#include "engine/base/json.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::tree {
namespace {

using nlohmann::json;

int depth_of(const Node& tree) {
  int below = 0;
  for (const Node& child : tree.children) below = std::max(below, depth_of(child));
  return 1 + below;
}

/// Where a node of a family belongs.
std::string_view home(Family family) {
  if (family == Family::geology) return "\"geology\" only";
  if (family == Family::distance) return "a distance tree, below \"from_distance\"";
  return family == Family::terrain ? "a terrain's tree" : "a field, not into a distance tree";
}

/// What a node may be inside of, and where problems go.
struct Reader {
  Context& context;
  Family family;
  Problems& problems;

  std::optional<Node> read(const json& value, const std::string& where) const {
    if (context.stopped) return std::nullopt;
    if (!value.is_object()) return fail(where, "must be an object with a \"type\" or a \"use\"");
    if (context.depth >= context.deepest) return too_deep(where);
    ++context.depth;
    auto node = value.contains("use") ? use(value, where) : typed(value, where);
    --context.depth;
    return node;
  }

 private:
  std::optional<Node> fail(const std::string& where, std::string what) const {
    problems.push_back({where, std::move(what)});
    return std::nullopt;
  }

  std::optional<Node> use(const json& value, const std::string& where) const {
    static constexpr std::array<std::string_view, 1> keys{"use"};
    report_unknown_keys(value, where, keys, problems);
    const auto name = read_text(value["use"], where + "/use", problems);
    if (!name) return std::nullopt;
    const auto found = context.definitions.find(*name);
    if (found == context.definitions.end()) {
      std::vector<std::string_view> names;
      for (const auto& [known, definition] : context.definitions) names.push_back(known);
      const std::string_view near = nearest(*name, names);
      return fail(where + "/use",
                  fmt::format("names \"{}\", which \"define\" does not hold{}", name->substr(0, 80),
                              near.empty() ? "" : fmt::format(", did you mean \"{}\"?", near)));
    }
    const auto open = std::find(context.open.begin(), context.open.end(), *name);
    if (open != context.open.end()) {
      std::string chain;
      for (auto link = open; link != context.open.end(); ++link) chain += *link + " -> ";
      return fail(where + "/use", fmt::format("is a cycle: {}{}", chain, *name));
    }
    const auto known = context.read.find({family, *name});
    if (known != context.read.end()) return again(known->second, where);
    context.open.push_back(*name);
    auto node = read(*found->second.json, found->second.where);
    context.open.pop_back();
    if (!context.stopped) {
      context.read[{family, *name}] = {node, node ? count(*node) : 0, node ? depth_of(*node) : 0};
    }
    return node;
  }

  /// One more copy of a definition, within the limits.
  std::optional<Node> again(const Context::Instance& instance, const std::string& where) const {
    if (context.depth + instance.depth > context.deepest) return too_deep(where);
    if (context.nodes_left < instance.nodes) return too_many(where);
    context.nodes_left -= instance.nodes;
    return instance.tree;
  }

  std::optional<Node> too_deep(const std::string& where) const {
    context.stopped = true;
    return fail(where, fmt::format("is nested deeper than {} nodes", context.deepest));
  }
  std::optional<Node> too_many(const std::string& where) const {
    context.stopped = true;
    return fail(where, "is one node too many: instances count as often as they are used");
  }

  std::optional<Node> typed(const json& value, const std::string& where) const {
    const auto type = value.find("type");
    if (type == value.end()) return fail(where, "must have a \"type\" or a \"use\"");
    if (!type->is_string()) return fail(where + "/type", "must be a text");
    if (context.nodes_left == 0) return too_many(where);
    --context.nodes_left;
    return one_of(type->get_ref<const std::string&>(), value, where,
                  static_cast<AnyNode*>(nullptr));
  }

  template <class... N>
  std::optional<Node> one_of(const std::string& type, const json& value, const std::string& where,
                             std::variant<N...>*) const {
    std::optional<Node> node;
    const bool known = ((type == N::type && (node = typed_as<N>(value, where), true)) || ...);
    if (known) return node;
    static constexpr std::array<std::string_view, sizeof...(N)> types{N::type...};
    const std::string_view near = nearest(type, types);
    return fail(where + "/type",
                fmt::format("names no node type: \"{}\"{}", type.substr(0, 80),
                            near.empty() ? "" : fmt::format(", did you mean \"{}\"?", near)));
  }

  template <class N>
  std::optional<Node> typed_as(const json& value, const std::string& where) const {
    if (!stands_in<N>(family)) {
      return fail(where + "/type", fmt::format("{} belongs into {}", N::type, home(N::family)));
    }
    N node;
    const std::size_t before = problems.size();
    read_fields(value, where, node, problems);
    std::vector<std::string_view> keys = field_keys<N>();
    keys.push_back("type");
    for (const Slot& slot : std::span<const Slot>(N::slots)) keys.push_back(slot.key);
    report_unknown_keys(value, where, keys, problems);
    if constexpr (Swarm<N>) {
      // Copies share the balls, but what is made of them does not.
      if (context.nodes_left < node.balls.size()) return too_many(where);
      context.nodes_left -= node.balls.size();
    }
    if (problems.size() == before) {
      add_voxels(node, where);
      check_balls(node, where);
      warn(node, where);
    }
    Node made{std::move(node), {}};
    for (const Slot& slot : std::span<const Slot>(N::slots)) {
      const Family inner = slot.family == Family::any ? family : slot.family;
      Reader{context, inner, problems}.fill(slot, value, where, made);
    }
    return made;
  }

  void fill(const Slot& slot, const json& value, const std::string& where, Node& into) const {
    const auto found = value.find(slot.key);
    const std::string at = fmt::format("{}/{}", where, slot.key);
    if (found == value.end()) {
      if (slot.least > 0) detail::missing(where, slot.key, problems);
      return;
    }
    if (!slot.list) {
      if (auto child = read(*found, at)) into.children.push_back(*std::move(child));
      return;
    }
    if (!found->is_array()) {
      problems.push_back({at, "must be an array of nodes"});
      return;
    }
    if (found->size() < slot.least || found->size() > slot.most) {
      problems.push_back({at, fmt::format("must hold {} to {} nodes, got {}", slot.least, slot.most,
                                          found->size())});
      return;
    }
    for (std::size_t i = 0; i < found->size(); ++i) {
      if (auto child = read((*found)[i], fmt::format("{}/{}", at, i))) {
        into.children.push_back(*std::move(child));
      }
    }
  }

  template <class N>
  void add_voxels(N& node, const std::string& where) const {
    if constexpr (requires { node.voxels; }) {
      if (!context.read_voxels) return;
      auto voxels = context.read_voxels(node.file, node.grid, where);
      if (!voxels) return;
      node.voxels = *std::move(voxels);
      node.file = "sha256:" + node.voxels.digest().hex();
      node.grid.clear();
    }
  }

  template <class N>
  void check_balls(const N& node, const std::string& where) const {
    if constexpr (Swarm<N>) {
      if (node.file.empty() || !context.check_balls) return;
      const auto least = context.check_balls(node.file, where);
      if constexpr (requires { node.check_least(1.0, where, problems); }) {
        if (least) node.check_least(*least, where, problems);
      }
    }
  }

  /// F = e g(0.4542 R - depth): the peak needs a depth of 0.4542 R.
  template <class N>
  void warn(const N& node, const std::string& where) const {
    if constexpr (VolumePrimitive<N>) {
      if (family == Family::distance) return;  // which takes no falloff
      bool fixed = true;
      int points = 0;
      Node probe{node, {}};
      for_each_point(probe, [&](Point& p) {
        fixed = fixed && p.form == Point::Form::fixed;
        ++points;
      });
      if (!fixed && points > 1) return;  // its length is not known yet
      const double half = node.half_thickness();
      if (node.falloff <= 2.2 * half) return;
      context.warnings.push_back(
          {where + "/falloff",
           fmt::format("{} m exceeds 2.2 x half the thickness ({:.6g} m): the field never reaches "
                       "its peak",
                       node.falloff, half)});
    }
  }
};

}  // namespace

std::optional<Node> parse_node(const json& value, const std::string& where, Family family,
                               Context& context, std::vector<Problem>& problems) {
  return Reader{context, family, problems}.read(value, where);
}

json to_json(const Node& tree) {
  return std::visit(
      [&](const auto& node) {
        using N = std::remove_cvref_t<decltype(node)>;
        json object{{"type", std::string(N::type)}};
        write_fields(node, object);
        std::size_t next = 0;
        for (const Slot& slot : std::span<const Slot>(N::slots)) {
          if (slot.list) {
            json list = json::array();
            std::size_t i = 0;
            for_each_child(tree, [&](const Node& child) {
              if (i++ >= next) list.push_back(to_json(child));
            });
            next = i;
            object[std::string(slot.key)] = std::move(list);
          } else if (next < tree.children.size()) {
            object[std::string(slot.key)] = to_json(tree.children[next++]);
          }
        }
        return object;
      },
      tree.value);
}

}  // namespace hoodoo::tree
