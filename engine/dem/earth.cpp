#include "engine/dem/earth.hpp"

#include <fmt/format.h>
#include <proj_experimental.h>

#include <cmath>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "engine/base/error.hpp"
#include "engine/dem/crs.hpp"

namespace hoodoo::dem {
namespace {

constexpr double cell = 256;          // of the lattice [m]
constexpr double tall = 1048576;      // a height [m] that tells the normal to 2^-32
constexpr double grain = 1.0 / 4096;  // of PROJ's answers [m]

double rounded(double v) { return std::floor(v / grain + 0.5) * grain; }

PjPointer compound(PJ_CONTEXT* context, PJ* plane, const std::string& vertical) {
  if (vertical == "ellipsoid") {
    return PjPointer(proj_crs_promote_to_3D(context, nullptr, plane));
  }
  const PjPointer heights(proj_create(context, vertical.c_str()));
  if (!heights || proj_get_type(heights.get()) != PJ_TYPE_VERTICAL_CRS) {
    throw Error(
        Fault::bad_input, "",
        fmt::format("{} is no vertical CRS; \"ellipsoid\" or one such as EPSG:5773 is", vertical));
  }
  return PjPointer(proj_create_compound_crs(context, "", plane, heights.get()));
}

/// The Lagrange cubic through values at -1, 0, 1, 2, and its slope.
struct Cubic {
  std::array<double, 4> value, slope;
  explicit Cubic(double t) {
    const double a = t + 1, b = t, c = t - 1, d = t - 2;
    value = {-b * c * d / 6, a * c * d / 2, -a * b * d / 2, a * b * c / 6};
    slope = {-(b * c + b * d + c * d) / 6, (a * c + a * d + c * d) / 2,
             -(a * b + a * d + b * d) / 2, (a * b + a * c + b * c) / 6};
  }
};

}  // namespace

/// PROJ's, one thread at a time.
struct Earth::Operation {
  ProjContext context;
  PjPointer pj;
  Frame frame;
  double height_unit = 1;  // [m]
  std::mutex mutex;

  explicit Operation(const Frame& f) : frame(f) {
    const std::string& vertical = frame.vertical;
    if (frame.crs.empty()) {
      throw Error(Fault::bad_input, "", "the elevations have no CRS: they lie nowhere on Earth");
    }
    PJ_CONTEXT* const c = context.get();
    const PjPointer stated(proj_create(c, frame.crs.c_str()));
    const PjPointer plane(stated ? proj_normalize_for_visualization(c, stated.get()) : nullptr);
    const PjPointer target(proj_create(c, "EPSG:4978"));
    if (!plane || !target) throw no_way("");
    const PjPointer source = compound(c, plane.get(), vertical);
    if (!source) throw no_way("");
    if (vertical != "ellipsoid") height_unit = unit_of(vertical);
    pj = best(source.get(), target.get());
  }

  /// Unrounded [m]. Errors: bad_input.
  Vec3 exact(double x, double y, double height) {
    const double px = (x + frame.origin_x) / frame.unit, py = (y + frame.origin_y) / frame.unit;
    PJ_COORD p;
    {
      const std::lock_guard lock(mutex);
      proj_errno_reset(pj.get());
      p = proj_trans(pj.get(), PJ_FWD, proj_coord(px, py, height / height_unit, HUGE_VAL));
    }
    if (!std::isfinite(p.xyz.x) || !std::isfinite(p.xyz.y) || !std::isfinite(p.xyz.z)) {
      throw Error(Fault::bad_input, "",
                  fmt::format("PROJ cannot place ({}, {}) of {} on the Earth, or its vertical "
                              "datum is not known there",
                              px, py, frame.crs));
    }
    return {p.xyz.x, p.xyz.y, p.xyz.z};
  }

 private:
  Error no_way(const std::string& grid) const {
    const auto why = grid.empty() ? std::string() : fmt::format(": its grid {} is missing", grid);
    return {Fault::bad_input, "",
            fmt::format("no way is known from {} with heights of {} to EPSG:4978{}", frame.crs,
                        frame.vertical, why)};
  }

  double unit_of(const std::string& vertical) const {
    PJ_CONTEXT* const c = context.get();
    const PjPointer crs(proj_create(c, vertical.c_str()));
    const PjPointer system(proj_crs_get_coordinate_system(c, crs.get()));
    double unit = 1;
    proj_cs_get_axis_info(c, system.get(), 0, nullptr, nullptr, nullptr, &unit, nullptr, nullptr,
                          nullptr);
    return unit;
  }

  using List = std::unique_ptr<PJ_OBJ_LIST, decltype(&proj_list_destroy)>;
  List operations(const PJ* source, const PJ* target, PROJ_GRID_AVAILABILITY_USE grids) const {
    PJ_CONTEXT* const c = context.get();
    const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT,
                          decltype(&proj_operation_factory_context_destroy)>
        factory(proj_create_operation_factory_context(c, nullptr),
                &proj_operation_factory_context_destroy);
    proj_operation_factory_context_set_grid_availability_use(c, factory.get(), grids);
    proj_operation_factory_context_set_allow_ballpark_transformations(c, factory.get(), 0);
    proj_operation_factory_context_set_spatial_criterion(
        c, factory.get(), PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
    return {proj_create_operations(c, source, target, factory.get()), &proj_list_destroy};
  }

  /// The one suggested at the scene's origin, all of whose grids are there.
  PjPointer best(const PJ* source, const PJ* target) const {
    PJ_CONTEXT* const c = context.get();
    const auto found =
        operations(source, target, PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID);
    if (!found || proj_list_get_count(found.get()) < 1) {
      throw no_way(missing_grid(source, target));
    }
    const int suggested = proj_get_suggested_operation(
        c, found.get(), PJ_FWD,
        proj_coord(frame.origin_x / frame.unit, frame.origin_y / frame.unit, 0, HUGE_VAL));
    PjPointer chosen(proj_list_get(c, found.get(), std::max(0, suggested)));
    if (!chosen) throw no_way("");
    return chosen;
  }

  std::string missing_grid(const PJ* source, const PJ* target) const {
    PJ_CONTEXT* const c = context.get();
    const auto all = operations(source, target, PROJ_GRID_AVAILABILITY_IGNORED);
    for (int i = 0; all && i < proj_list_get_count(all.get()); ++i) {
      const PjPointer operation(proj_list_get(c, all.get(), i));
      for (int g = 0; g < proj_coordoperation_get_grid_used_count(c, operation.get()); ++g) {
        const char* name = nullptr;
        int there = 0;
        if (proj_coordoperation_get_grid_used(c, operation.get(), g, &name, nullptr, nullptr,
                                              nullptr, nullptr, nullptr, &there) &&
            there == 0 && name != nullptr) {
          return name;
        }
      }
    }
    return "";
  }
};

/// Corners that one call has asked for.
class Earth::Lattice {
 public:
  explicit Lattice(const Earth& earth) : earth_(earth) {}

  Place place(const Vec3& p) {
    const double u = p.x / cell, v = p.y / cell;
    const double i = std::floor(u), j = std::floor(v);
    const Cubic x(u - i), y(v - j);
    Place place{};
    for (std::size_t b = 0; b < 4; ++b) {
      for (std::size_t a = 0; a < 4; ++a) {
        const auto& c = corner(static_cast<std::int64_t>(i) + static_cast<std::int64_t>(a) - 1,
                               static_cast<std::int64_t>(j) + static_cast<std::int64_t>(b) - 1);
        const Vec3 at = c.ground + c.normal * p.z;
        place.at = place.at + at * (x.value[a] * y.value[b]);
        place.axes[0] = place.axes[0] + at * (x.slope[a] * y.value[b] / cell);
        place.axes[1] = place.axes[1] + at * (x.value[a] * y.slope[b] / cell);
        place.axes[2] = place.axes[2] + c.normal * (x.value[a] * y.value[b]);
      }
    }
    return place;
  }

 private:
  /// A place at height 0 and the way of a metre of height, in the rigid frame.
  struct Corner {
    Vec3 ground, normal;
  };
  const Corner& corner(std::int64_t i, std::int64_t j) {
    const auto key =
        static_cast<std::uint64_t>(i) << 32 ^ (static_cast<std::uint64_t>(j) & 0xffffffffU);
    const auto [at, is_new] = corners_.try_emplace(key);
    if (is_new) {
      const double x = static_cast<double>(i) * cell, y = static_cast<double>(j) * cell;
      const Vec3 low = seen(x, y, 0), high = seen(x, y, tall);
      at->second = {low, (high - low) * (1 / tall)};
    }
    return at->second;
  }
  Vec3 seen(double x, double y, double height) const {
    const Vec3 p = earth_.operation_->exact(x, y, height);
    const Vec3 away = Vec3{rounded(p.x), rounded(p.y), rounded(p.z)} - earth_.origin_;
    const auto& turn = earth_.turn_;
    return {dot(turn[0], away), dot(turn[1], away), dot(turn[2], away)};
  }

  const Earth& earth_;
  std::unordered_map<std::uint64_t, Corner> corners_;
};

Earth::Earth(const Frame& frame) : operation_(std::make_unique<Operation>(frame)) {
  const Vec3 low = operation_->exact(0, 0, 0), high = operation_->exact(0, 0, tall);
  origin_ = {rounded(low.x), rounded(low.y), rounded(low.z)};
  const Vec3 up = normalized(Vec3{rounded(high.x), rounded(high.y), rounded(high.z)} - origin_);
  const Vec3 east = normalized({-up.y, up.x, 0}, {0, 1, 0});  // any way at a pole
  turn_ = {east, cross(up, east), up};
}
Earth::~Earth() = default;
Earth::Earth(Earth&&) noexcept = default;
Earth& Earth::operator=(Earth&&) noexcept = default;

std::vector<Earth::Place> Earth::places(std::span<const Vec3> scene) const {
  Lattice lattice(*this);
  std::vector<Place> places;
  places.reserve(scene.size());
  for (const Vec3& p : scene) places.push_back(lattice.place(p));
  return places;
}

std::vector<Vec3> Earth::scene(std::span<const Vec3> local) const {
  Lattice lattice(*this);
  std::vector<Vec3> scene;
  scene.reserve(local.size());
  Vec3 p;
  for (const Vec3& wanted : local) {
    for (int step = 0; step < 20; ++step) {  // Newton's, from the point before
      const Place here = lattice.place(p);
      const Vec3 off = wanted - here.at;
      const auto& [a, b, c] = here.axes;
      const double volume = dot(a, cross(b, c));
      p = p +
          Vec3{dot(off, cross(b, c)), dot(off, cross(c, a)), dot(off, cross(a, b))} * (1 / volume);
      if (dot(off, off) < 1e-12) break;
    }
    scene.push_back(p);
  }
  return scene;
}

std::array<double, 16> Earth::transform() const {
  const auto& [e, n, u] = turn_;
  return {e.x, e.y, e.z, 0, n.x, n.y, n.z, 0, u.x, u.y, u.z, 0, origin_.x, origin_.y, origin_.z, 1};
}

}  // namespace hoodoo::dem
