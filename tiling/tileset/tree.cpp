#include "tiling/tileset/tree.hpp"

#include <algorithm>

namespace hoodoo::tileset {
namespace {

/// The four keys below one, in the order of keys.
std::vector<plan::Key> below(const plan::Key& key) {
  const int level = key.level - 1;
  const auto x = 2 * key.x, y = 2 * key.y;
  return {{level, x, y}, {level, x, y + 1}, {level, x + 1, y}, {level, x + 1, y + 1}};
}

}  // namespace

Tree make_tree(const Bake& bake) {
  Tree tree;
  std::map<plan::Key, const Record*> finished;
  for (const auto& record : bake.records) finished[record.key] = &record;
  auto planned = bake.planned;
  std::ranges::sort(planned);         // by level, finest first
  std::map<plan::Key, bool> covered;  // of the planned: whether all of its area is finished
  for (const auto& key : planned) {
    Tree::Node node;
    const auto at = finished.find(key);
    if (at != finished.end()) node.record = at->second;
    bool all = key.level > 0, any = false;
    if (key.level > 0) {
      for (const auto& child : below(key)) {
        const auto state = covered.find(child);
        if (state == covered.end()) continue;  // never planned
        any = true;
        all = all && state->second;
        if (tree.nodes.contains(child)) node.children.push_back(child);
      }
    }
    covered[key] = node.record != nullptr || (any && all);
    if (node.has_content() && !all) node.children.clear();
    for (const auto& child : node.children) node.box.add(tree.nodes.at(child).box);
    if (node.has_content()) node.box.add(node.record->box);
    if (node.has_content() || !node.children.empty()) tree.nodes.emplace(key, std::move(node));
  }
  const int top = planned.empty() ? 0 : planned.back().level;
  for (const auto& [key, node] : tree.nodes) {
    if (key.level == top) tree.roots.push_back(key);
  }
  return tree;
}

}  // namespace hoodoo::tileset
