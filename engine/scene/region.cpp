#include "engine/scene/region.hpp"

#include <utility>

#include "engine/scene/mask.hpp"
#include "engine/scene/read_object.hpp"

namespace hoodoo::scene {
namespace {

/// Turns what a scene says into what evaluates.
struct Build {
  const std::string& where;
  const Sources& sources;
  std::size_t& pixels_left;
  Findings& findings;

  bool operator()(const BoxRegion& from, tree::Region& into) const {
    into.box = {from.min, from.max};
    into.feather = from.feather;
    return true;
  }
  bool operator()(const PolygonRegion& from, tree::Region& into) const {
    into.polygon = from.points;
    into.feather = from.feather;
    return true;
  }
  bool operator()(const AltitudeRegion& from, tree::Region& into) const {
    into.box.min.z = from.range[0];
    into.box.max.z = from.range[1];
    into.feather = from.feather;
    return true;
  }
  bool operator()(const MaskRegion& from, tree::Region& into) const {
    const auto at = where + "/image";
    const auto file = find_file(from.image, at, sources, findings);
    if (!file) return false;
    auto mask = read_mask(*file, from.image, at, pixels_left, findings);
    if (!mask) return false;
    into.mask = *std::move(mask);
    into.mask.x0 = from.min[0];
    into.mask.y0 = from.min[1];
    into.mask.x1 = from.max[0];
    into.mask.y1 = from.max[1];
    into.feather = 0;
    return true;
  }
};

}  // namespace

void BoxRegion::check(const std::string& where, std::vector<Problem>& problems) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (min[axis] < max[axis]) continue;
    problems.push_back(
        {fmt::format("{}/max/{}", where, axis),
         fmt::format("must be above \"min\", {} m, got {} m", min[axis], max[axis])});
  }
}

void MaskRegion::check(const std::string& where, std::vector<Problem>& problems) const {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (min[axis] < max[axis]) continue;
    problems.push_back(
        {fmt::format("{}/max/{}", where, axis),
         fmt::format("must be above \"min\", {} m, got {} m", min[axis], max[axis])});
  }
}

std::shared_ptr<const tree::Region> read_region(const nlohmann::json& json,
                                                const std::string& where, const Sources& sources,
                                                std::size_t& pixels_left, Findings& findings) {
  const auto before = findings.problems.size();
  const auto region = Types<AnyRegion>::read(json, where, findings.problems);
  if (!region || findings.problems.size() != before) return nullptr;
  auto made = std::make_shared<tree::Region>();
  const Build build{where, sources, pixels_left, findings};
  const bool right = std::visit([&](const auto& one) { return build(one, *made); }, *region);
  return right ? made : nullptr;
}

}  // namespace hoodoo::scene
