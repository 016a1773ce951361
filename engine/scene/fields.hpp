#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/box.hpp"
#include "engine/base/error.hpp"
#include "engine/tree/fields.hpp"
#include "engine/tree/polygon.hpp"

/// Values with JSON forms of their own, of what a scene says beside its trees. Settings list them
/// together with the descriptors of engine/tree/fields.hpp; read_object.hpp derives parser and
/// schema from the list.
namespace hoodoo::scene {

using tree::Form;
using tree::Special;
using Pair = std::array<double, 2>;
using Colour = std::array<std::uint8_t, 3>;

namespace form {
std::optional<Colour> read_colour(const nlohmann::json&, const std::string&, std::vector<Problem>&);
std::optional<Pair> read_share(const nlohmann::json&, const std::string&, std::vector<Problem>&);
std::optional<Pair> read_altitude(const nlohmann::json&, const std::string&, std::vector<Problem>&);
std::optional<Pair> read_plan(const nlohmann::json&, const std::string&, std::vector<Problem>&);
std::optional<tree::Polygon> read_outline(const nlohmann::json&, const std::string&,
                                          std::vector<Problem>&);
std::optional<std::optional<double>> read_fill(const nlohmann::json&, const std::string&,
                                               std::vector<Problem>&);
std::optional<std::optional<Box>> read_extent(const nlohmann::json&, const std::string&,
                                              std::vector<Problem>&);
std::optional<std::string> read_profile(const nlohmann::json&, const std::string&,
                                        std::vector<Problem>&);
std::optional<std::string> read_frame(const nlohmann::json&, const std::string&,
                                      std::vector<Problem>&);
std::optional<std::optional<double>> read_base(const nlohmann::json&, const std::string&,
                                               std::vector<Problem>&);
nlohmann::json base_schema();
nlohmann::json colour_schema();
nlohmann::json share_schema();
nlohmann::json altitude_schema();
nlohmann::json plan_schema();
nlohmann::json outline_schema();
nlohmann::json fill_schema();
nlohmann::json extent_schema();
nlohmann::json profile_schema();
nlohmann::json frame_schema();
}  // namespace form

/// "#rrggbb", sRGB.
inline constexpr Form<Colour> colour_form{&form::read_colour, &form::colour_schema};
/// [low, high] within [0, 1].
inline constexpr Form<Pair> share_form{&form::read_share, &form::share_schema};
/// [low, high] [m], low < high.
inline constexpr Form<Pair> altitude_form{&form::read_altitude, &form::altitude_schema};
/// [x, y] [m].
inline constexpr Form<Pair> plan_form{&form::read_plan, &form::plan_schema};
/// [[x, y], ...] [m]: a polygon of at least three corners that encloses an area.
inline constexpr Form<tree::Polygon> outline_form{&form::read_outline, &form::outline_schema};
/// "hole" (none), or an elevation [m].
inline constexpr Form<std::optional<double>> fill_form{&form::read_fill, &form::fill_schema};
/// {"min": [x, y], "max": [x, y]} [m], or null (none); z is not bounded.
inline constexpr Form<std::optional<Box>> extent_form{&form::read_extent, &form::extent_schema};
/// {"closed": depth} [m], or null (none).
inline constexpr Form<std::optional<double>> base_form{&form::read_base, &form::base_schema};
/// "draco" or "plain".
inline constexpr Form<std::string> profile_form{&form::read_profile, &form::profile_schema};
/// "local" or "ecef".
inline constexpr Form<std::string> frame_form{&form::read_frame, &form::frame_schema};

}  // namespace hoodoo::scene
