#include "engine/dem/crs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/base/error.hpp"

namespace hoodoo::dem {
namespace {

PjPointer horizontal(PJ_CONTEXT* context, PjPointer crs) {
  // Compound: the first is horizontal. Bound: a CRS with a stated shift to another.
  for (int depth = 0; crs && depth < 4; ++depth) {
    const auto type = proj_get_type(crs.get());
    if (type == PJ_TYPE_COMPOUND_CRS) {
      crs.reset(proj_crs_get_sub_crs(context, crs.get(), 0));
    } else if (type == PJ_TYPE_BOUND_CRS) {
      crs.reset(proj_get_source_crs(context, crs.get()));
    } else {
      break;
    }
  }
  return crs;
}

double axis_unit(PJ_CONTEXT* context, const PJ* crs) {
  const PjPointer system(proj_crs_get_coordinate_system(context, crs));
  double unit = 1;
  if (!system || !proj_cs_get_axis_info(context, system.get(), 0, nullptr, nullptr, nullptr, &unit,
                                        nullptr, nullptr, nullptr)) {
    return 1;
  }
  return unit;
}

// EPSG method 1024, or Mercator on a sphere of the equator's radius, as files spell it that give
// their CRS by parameters.
bool is_web_mercator(PJ_CONTEXT* context, const PJ* crs) {
  const PjPointer operation(proj_crs_get_coordoperation(context, crs));
  if (!operation) return false;
  const char* method = nullptr;
  const char* code = nullptr;
  if (!proj_coordoperation_get_method_info(context, operation.get(), &method, nullptr, &code)) {
    return false;
  }
  if (code && std::strcmp(code, "1024") == 0) return true;
  if (!method || !std::strstr(method, "Mercator") || std::strstr(method, "Transverse") ||
      std::strstr(method, "Oblique")) {
    return false;
  }
  const PjPointer ellipsoid(proj_get_ellipsoid(context, crs));
  double major = 0, minor = 0;
  return ellipsoid &&
         proj_ellipsoid_get_parameters(context, ellipsoid.get(), &major, &minor, nullptr,
                                       nullptr) &&
         major == minor && major == 6378137;
}

PjPointer east_first(PJ_CONTEXT* context, const std::string& definition) {
  PjPointer crs(proj_create(context, definition.c_str()));
  if (!crs) return crs;
  PjPointer ordered(proj_normalize_for_visualization(context, crs.get()));
  return ordered ? std::move(ordered) : std::move(crs);
}

}  // namespace

ProjContext::ProjContext() : context_(proj_context_create()) {
  proj_log_level(get(), PJ_LOG_NONE);
  proj_log_func(get(), nullptr, [](void*, int, const char*) {});
  proj_context_set_enable_network(get(), 0);
}

std::optional<CrsFacts> describe(const ProjContext& context, const std::string& definition) {
  PJ_CONTEXT* const c = context.get();
  const auto crs = horizontal(c, PjPointer(proj_create(c, definition.c_str())));
  if (!crs) return std::nullopt;
  const char* const name = proj_get_name(crs.get());
  CrsFacts facts{RasterInfo::Crs::none, name ? name : "", 1};
  switch (proj_get_type(crs.get())) {
    case PJ_TYPE_GEOGRAPHIC_2D_CRS:
    case PJ_TYPE_GEOGRAPHIC_3D_CRS:
      facts.kind = RasterInfo::Crs::geographic;
      return facts;
    case PJ_TYPE_PROJECTED_CRS:
      facts.kind = is_web_mercator(c, crs.get()) ? RasterInfo::Crs::web_mercator
                                                 : RasterInfo::Crs::projected;
      facts.unit = axis_unit(c, crs.get());
      if (!(facts.unit > 0) || !std::isfinite(facts.unit)) return std::nullopt;
      return facts;
    default:
      return std::nullopt;
  }
}

bool same_crs(const std::string& a, const std::string& b) {
  if (a == b) return true;
  if (a.empty() || b.empty()) return false;
  const ProjContext context;
  const auto one = horizontal(context.get(), east_first(context.get(), a));
  const auto other = horizontal(context.get(), east_first(context.get(), b));
  return one && other &&
         proj_is_equivalent_to_with_ctx(context.get(), one.get(), other.get(), PJ_COMP_EQUIVALENT);
}

Mapping::Mapping(const std::string& from, const std::string& to, Point near) {
  PJ_CONTEXT* const c = context_.get();
  const auto source = east_first(c, from);
  const auto target = east_first(c, to);
  const auto none = [&] {
    return Error(Fault::bad_input, "", fmt::format("no way is known from {} to {}", from, to));
  };
  if (!source || !target) throw none();
  const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT,
                        decltype(&proj_operation_factory_context_destroy)>
      factory(proj_create_operation_factory_context(c, nullptr),
              &proj_operation_factory_context_destroy);
  proj_operation_factory_context_set_grid_availability_use(
      c, factory.get(), PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID);
  proj_operation_factory_context_set_spatial_criterion(c, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  const std::unique_ptr<PJ_OBJ_LIST, decltype(&proj_list_destroy)> operations(
      proj_create_operations(c, source.get(), target.get(), factory.get()), &proj_list_destroy);
  if (!operations || proj_list_get_count(operations.get()) < 1) throw none();
  const int suggested = proj_get_suggested_operation(c, operations.get(), PJ_FWD,
                                                     proj_coord(near.x, near.y, 0, HUGE_VAL));
  operation_.reset(proj_list_get(c, operations.get(), std::max(0, suggested)));
  if (!operation_) throw none();
}

std::optional<Point> Mapping::transform(Point p, PJ_DIRECTION direction) const {
  proj_errno_reset(operation_.get());
  const auto moved = proj_trans(operation_.get(), direction, proj_coord(p.x, p.y, 0, HUGE_VAL));
  if (!std::isfinite(moved.xy.x) || !std::isfinite(moved.xy.y)) return std::nullopt;
  return Point{moved.xy.x, moved.xy.y};
}

}  // namespace hoodoo::dem
