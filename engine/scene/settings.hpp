#pragma once
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "engine/scene/fields.hpp"
#include "engine/tree/ground.hpp"

/// The parts of a scene that are neither trees nor operations, as their JSON states them.
namespace hoodoo::scene {

/// The scene's own keys.
struct Header {
  int hoodoo = 1;
  std::string name;
  std::uint64_t seed = 0;

  static constexpr auto fields() {
    using T = Header;
    return std::tuple{
        tree::Whole<T>{"hoodoo", &T::hoodoo, 1, 1, tree::required, "Version of this format."},
        tree::Text<T>{"name", &T::name, "", "For people."},
        tree::Whole<T, std::uint64_t>{"seed", &T::seed, 0, 9007199254740991LL, std::uint64_t{0},
                                      "Varies everything random in the scene."}};
  }
};

/// One of "materials".
struct MaterialSettings {
  std::string name;
  Colour color{};
  Pair resistance{};
  double friction = 0;
  std::string stratum;

  static constexpr auto fields() {
    using T = MaterialSettings;
    return std::tuple{
        tree::Text<T>{"name", &T::name, tree::required, "Names it, uniquely."},
        Special<T, Colour>{"color", &T::color, colour_form, Colour{0x9a, 0x93, 0x88},
                           "sRGB colour as \"#rrggbb\"."},
        Special<T, Pair>{"resistance", &T::resistance, share_form, Pair{0, 1},
                         "The rock is this material where its resistance to erosion is in "
                         "[low, high)."},
        tree::Number<T>{"friction", &T::friction, "1", tree::within(0, 10), 0.7,
                        "Coefficient of friction, for physics."},
        tree::Text<T>{
            "stratum", &T::stratum, "",
            "The rock is this material where the geology's stratum of this name prevails, "
            "whatever its resistance there."}};
  }
  void check(const std::string& where, std::vector<Problem>& problems) const;
  tree::Material material() const {
    return {name, color, resistance[0], resistance[1], friction, stratum};
  }
};

/// One of "terrains".
struct TerrainSettings {
  std::string id;
  std::string dem;
  std::optional<double> falloff;
  std::optional<double> nodata;
  bool slope_corrected = false;
  bool inverted = false;
  double offset = 0;
  tree::Polygon domain;

  static constexpr auto fields() {
    using T = TerrainSettings;
    return std::tuple{
        tree::Text<T>{"id", &T::id, "", "Names it, uniquely."},
        tree::Text<T>{"dem", &T::dem, tree::required,
                      "GeoTIFF of elevations, relative to the scene file."},
        tree::OptionalNumber<T>{"falloff", &T::falloff, "m", tree::above(0, tree::longest),
                                "Height over which the field falls from rock to air on either "
                                "side of the ground; by default 4 spacings."},
        Special<T, std::optional<double>>{
            "nodata", &T::nodata, fill_form, std::optional<double>(),
            "What NoData becomes: a hole in the world, or this elevation [m]."},
        tree::Flag<T>{"slope_corrected", &T::slope_corrected, false,
                      "Measure the falloff across the slope, not along z."},
        tree::Flag<T>{"inverted", &T::inverted, false, "Solid above the elevations, not below."},
        tree::Number<T>{"offset", &T::offset, "m", tree::within(-tree::farthest, tree::farthest),
                        0.0, "Added to every elevation."},
        Special<T, tree::Polygon>{
            "domain", &T::domain, outline_form, tree::Polygon(),
            "Corners [x, y] [m] of the only part to take, as a body of its own."}};
  }
  /// `spacing` [m] is s_0 of the scene.
  tree::HeightBody body(double spacing) const {
    return {id, falloff.value_or(4 * spacing), slope_corrected, inverted, offset, domain};
  }
};

}  // namespace hoodoo::scene
