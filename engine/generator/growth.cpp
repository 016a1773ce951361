#include "engine/generator/growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.hpp"

namespace hoodoo::generator {
namespace {

/// The value of that name, new where there is none.
template <class Value>
Value& named(std::vector<std::pair<std::string, Value>>& list, std::string_view name) {
  const auto found = std::ranges::find(list, name, &std::pair<std::string, Value>::first);
  return found == list.end() ? list.emplace_back(std::string(name), Value()).second : found->second;
}

}  // namespace

void Record::count(std::string_view what, std::uint64_t by) { named(counts, what) += by; }

std::vector<Mark>& Record::list(std::string_view name) { return named(marks, name); }

std::vector<Edge>& Record::edges_of(std::string_view list) { return named(edges, list); }

Box Growth::reach() const {
  Box world = site.extent();
  const Box steps = tree::influence(site.ground());
  if (!steps.empty() && std::isfinite(steps.min.z)) {
    world.min.z = std::min(world.min.z, steps.min.z);
  }
  if (!steps.empty() && std::isfinite(steps.max.z)) {
    world.max.z = std::max(world.max.z, steps.max.z);
  }
  return region ? intersection(world, region->influence()) : world;
}

void Growth::add(tree::Operation operation, tree::Node tree,
                 std::shared_ptr<const tree::Region> where) {
  site.add({record.id, record.where, operation, std::move(tree), std::move(where), material});
  ++record.steps;
}

void expect_few(std::size_t count, std::size_t most, std::string_view what) {
  if (count <= most) return;
  throw Error(Fault::limit, "",
              fmt::format("places {} {}, the limit is {}: make the region smaller or the distance "
                          "between them larger",
                          count, what, most));
}

}  // namespace hoodoo::generator
