#pragma once
#include <proj.h>

#include <memory>
#include <optional>
#include <string>

#include "engine/dem/raster.hpp"

namespace hoodoo::dem {

/// A point of a plane or of longitude and latitude, in the units of its CRS; x goes east.
struct Point {
  double x, y;
};

/// PROJ's state for one thread. It prints nothing, and asks no network for grids.
class ProjContext {
 public:
  ProjContext();
  PJ_CONTEXT* get() const { return context_.get(); }

 private:
  struct Destroy {
    void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
  };
  std::unique_ptr<PJ_CONTEXT, Destroy> context_;
};

struct PjDestroy {
  void operator()(PJ* pj) const { proj_destroy(pj); }
};
using PjPointer = std::unique_ptr<PJ, PjDestroy>;

/// What PROJ knows of a CRS.
struct CrsFacts {
  RasterInfo::Crs kind;
  std::string name;
  double unit = 1;  // metres per unit, projected only
};

/// Nothing when PROJ does not know `definition`, or it is neither geographic nor projected.
std::optional<CrsFacts> describe(const ProjContext& context, const std::string& definition);

/// True when both definitions mean the same plane coordinates.
bool same_crs(const std::string& a, const std::string& b);

/// Points of one CRS in another: a single operation of PROJ, the one suggested near `near`, so that
/// there is no seam where PROJ would change from one datum shift to the next. For one thread.
class Mapping {
 public:
  /// Errors: bad_input naming `from` and `to`.
  Mapping(const std::string& from, const std::string& to, Point near);
  std::optional<Point> forward(Point p) const { return transform(p, PJ_FWD); }
  std::optional<Point> inverse(Point p) const { return transform(p, PJ_INV); }

 private:
  std::optional<Point> transform(Point p, PJ_DIRECTION direction) const;

  ProjContext context_;
  PjPointer operation_;
};

}  // namespace hoodoo::dem
