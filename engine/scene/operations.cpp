#include "engine/scene/operations.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/scene/read_object.hpp"
#include "engine/scene/region.hpp"

namespace hoodoo::scene {
namespace {

using nlohmann::json;

constexpr std::size_t most_operations = 1'000'000;
constexpr std::size_t most_problems = 1000;  // later operations are not read then
constexpr std::size_t most_mask_pixels = std::size_t{1} << 24;
constexpr std::array<std::string_view, 5> common_keys = {"id", "region", "material", "mirror",
                                                         "variants"};

/// Reads one operation after the other.
class Reader {
 public:
  Reader(const Sources& sources, const std::vector<MaterialSettings>& materials,
         tree::Context& context, Findings& findings)
      : sources_(sources), materials_(materials), context_(context), findings_(findings) {}

  std::optional<QueuedOperation> read(const json& from, const std::string& where) {
    auto& problems = findings_.problems;
    if (!from.is_object()) {
      problems.push_back({where, "must be an object"});
      return std::nullopt;
    }
    const auto before = before_ = problems.size();
    QueuedOperation made{&from, where, {}, {}, -1, {}, {}, {}};
    read_settings(from, where, made);
    if (const auto region = from.find("region"); region != from.end()) {
      made.region = read_region(*region, where + "/region", sources_, pixels_left_, findings_);
    }
    made.copies.mirror = read_copies<MirrorSettings>(from, where, "mirror");
    made.copies.variants = read_copies<VariantSettings>(from, where, "variants");
    if (from.contains("type")) {
      read_tool(from, where, made);
    } else {
      read_operation(from, where, made);
    }
    if (problems.size() != before) return std::nullopt;
    return made;
  }

 private:
  template <class T>
  std::optional<T> read_copies(const json& from, const std::string& where, const char* key) {
    const auto found = from.find(key);
    if (found == from.end()) return std::nullopt;
    T settings;
    read_object(*found, fmt::format("{}/{}", where, key), settings, findings_.problems);
    return settings;
  }

  void read_settings(const json& from, const std::string& where, QueuedOperation& made) {
    auto& problems = findings_.problems;
    OperationSettings settings;
    tree::read_fields(from, where, settings, problems);
    made.id = settings.id;
    if (!made.id.empty()) {
      const auto [other, fresh] = ids_.emplace(made.id, where);
      if (!fresh) {
        problems.push_back({where + "/id", fmt::format("is that of {} too", other->second)});
      }
    }
    if (!settings.material.empty()) made.material = material(settings.material, where);
  }

  int material(const std::string& name, const std::string& where) {
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      if (materials_[i].name == name) return static_cast<int>(i);
      names.push_back(materials_[i].name);
    }
    const auto near = tree::nearest(name, names);
    findings_.problems.push_back(
        {where + "/material",
         near.empty()
             ? fmt::format("no material is named \"{}\"", name)
             : fmt::format("no material is named \"{}\": did you mean \"{}\"?", name, near)});
    return -1;
  }

  void read_tool(const json& from, const std::string& where, QueuedOperation& made) {
    auto tool = Types<AnyTool>::read(from, where, findings_.problems,
                                     {common_keys.begin(), common_keys.end()});
    if (!tool) return;
    std::visit(
        [&]<class T>(const T& one) {
          if constexpr (Brush<T>) {
            made.operation = one.op;
          } else {
            refuse_copies(made.copies, T::type, where);
          }
        },
        *tool);
    read_trees(where, *tool);
    made.shape = *std::move(tool);
  }

  void refuse_copies(const Copies& copies, std::string_view type, const std::string& where) {
    for (const auto& [key, given] : {std::pair("mirror", copies.mirror.has_value()),
                                     std::pair("variants", copies.variants.has_value())}) {
      if (!given) continue;
      findings_.problems.push_back(
          {where + "/" + key,
           fmt::format("is for brushes and trees, not for the generator \"{}\"", type)});
    }
  }

  /// The trees that a generator holds, now that the scene's definitions are known.
  void read_trees(const std::string& where, AnyTool& tool) {
    if (findings_.problems.size() > before_) return;
    const generator::ReadTree read = [&](const json& stated, const std::string& at) {
      return scene::read_tree(stated, at, tree::Family::terrain, context_, findings_);
    };
    std::visit(
        [&]<class T>(T& one) {
          if constexpr (requires { one.read_trees(where, read, findings_.problems); }) {
            one.read_trees(where, read, findings_.problems);
          }
        },
        tool);
  }

  void read_operation(const json& from, const std::string& where, QueuedOperation& made) {
    auto& problems = findings_.problems;
    if (!from.contains("op") && !from.contains("tree")) {
      problems.push_back({where, "must have \"op\" and \"tree\", or \"type\""});
      return;
    }
    TreeOperation operation;
    std::vector<std::string_view> others(common_keys.begin(), common_keys.end());
    others.insert(others.end(), {"tree", "type"});
    read_object(from, where, operation, problems, others);
    made.operation = operation.op;
    const auto tree = from.find("tree");
    if (tree == from.end()) {
      problems.push_back({where + "/tree", "is missing"});
      return;
    }
    auto node =
        scene::read_tree(*tree, where + "/tree", tree::Family::terrain, context_, findings_);
    if (node) made.shape = *std::move(node);
  }

  const Sources& sources_;
  const std::vector<MaterialSettings>& materials_;
  tree::Context& context_;
  Findings& findings_;
  std::size_t before_ = 0;  // problems, when the operation was begun
  std::size_t pixels_left_ = most_mask_pixels;
  std::map<std::string, std::string> ids_;  // to the operation that has it
};

}  // namespace

std::optional<tree::Node> read_tree(const json& from, const std::string& where, tree::Family family,
                                    tree::Context& context, Findings& findings) {
  const bool stopped = context.stopped;
  auto node = tree::parse_node(from, where, family, context, findings.problems);
  if (context.stopped && !stopped) {
    findings.limits.push_back(std::move(findings.problems.back()));
    findings.problems.pop_back();
  }
  return node;
}

std::vector<QueuedOperation> read_operations(const json& scene, const Sources& sources,
                                             const std::vector<MaterialSettings>& materials,
                                             tree::Context& context, Findings& findings) {
  std::vector<QueuedOperation> queue;
  const auto found = scene.find("operations");
  if (found == scene.end()) return queue;
  const std::string where = "/operations";
  if (!found->is_array()) {
    findings.problems.push_back({where, "must be an array"});
    return queue;
  }
  if (found->size() > most_operations) {
    findings.limits.push_back(
        {where, fmt::format("has {} operations, the limit is {}", found->size(), most_operations)});
    return queue;
  }
  Reader reader(sources, materials, context, findings);
  for (std::size_t i = 0; i < found->size() && findings.problems.size() < most_problems; ++i) {
    auto one = reader.read((*found)[i], fmt::format("{}/{}", where, i));
    if (one) queue.push_back(*std::move(one));
  }
  return queue;
}

}  // namespace hoodoo::scene
