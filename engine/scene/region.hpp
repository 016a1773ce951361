#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "engine/scene/fields.hpp"
#include "engine/scene/files.hpp"
#include "engine/tree/region.hpp"

/// The regions of operations, as their JSON states them.
namespace hoodoo::scene {

template <class T>
constexpr auto feather_field() {
  return tree::Number<T>{"feather", &T::feather,
                         "m",       tree::within(0, tree::longest),
                         1.0,       "Width over which the operation fades out across the edge."};
}

struct BoxRegion {
  static constexpr std::string_view type = "box";
  static constexpr std::string_view doc = "Inside an axis-aligned box.";
  Vec3 min, max;
  double feather = 1;

  static constexpr auto fields() {
    using T = BoxRegion;
    constexpr auto range = tree::within(-tree::farthest, tree::farthest);
    return std::tuple{
        tree::Vector<T>{"min", &T::min, "m", range, tree::required, "Lowest corner."},
        tree::Vector<T>{"max", &T::max, "m", range, tree::required, "Highest corner."},
        feather_field<T>()};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
};

struct PolygonRegion {
  static constexpr std::string_view type = "polygon";
  static constexpr std::string_view doc = "Inside a polygon in plan, at any height.";
  tree::Polygon points;
  double feather = 1;

  static constexpr auto fields() {
    using T = PolygonRegion;
    return std::tuple{Special<T, tree::Polygon>{"points", &T::points, outline_form, tree::required,
                                                "Corners [x, y] [m]."},
                      feather_field<T>()};
  }
};

struct AltitudeRegion {
  static constexpr std::string_view type = "altitude";
  static constexpr std::string_view doc = "Between two heights.";
  Pair range{};
  double feather = 1;

  static constexpr auto fields() {
    using T = AltitudeRegion;
    return std::tuple{Special<T, Pair>{"range", &T::range, altitude_form, tree::required,
                                       "Lowest and highest z [m]."},
                      feather_field<T>()};
  }
};

struct MaskRegion {
  static constexpr std::string_view type = "mask";
  static constexpr std::string_view doc =
      "Where an image is painted: white acts, black does not, grey acts in part.";
  std::string image;
  Pair min{}, max{};

  static constexpr auto fields() {
    using T = MaskRegion;
    return std::tuple{
        tree::Text<T>{"image", &T::image, tree::required,
                      "PNG or TIFF of 8 or 16 bits, north up, its first channel is taken; "
                      "relative to the scene file."},
        Special<T, Pair>{"min", &T::min, plan_form, tree::required,
                         "South-west corner [x, y] [m] of the image."},
        Special<T, Pair>{"max", &T::max, plan_form, tree::required,
                         "North-east corner [x, y] [m] of the image."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
};

/// Every kind of region there is.
using AnyRegion = std::variant<BoxRegion, PolygonRegion, AltitudeRegion, MaskRegion>;

/// Reads one region; null when it has problems. `pixels_left` is what masks may still hold.
std::shared_ptr<const tree::Region> read_region(const nlohmann::json& json,
                                                const std::string& where, const Sources& sources,
                                                std::size_t& pixels_left, Findings& findings);

}  // namespace hoodoo::scene
