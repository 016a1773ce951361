#include "engine/scene/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/tree/read_fields.hpp"

namespace hoodoo::scene::form {
namespace {

using nlohmann::json;
using tree::Problems;

constexpr std::array<std::string_view, 3> profiles = {"draco", "meshopt", "plain"};
constexpr std::array<std::string_view, 2> frames = {"local", "ecef"};
constexpr std::size_t most_corners = 100'000;
constexpr tree::Range base_depth = tree::above(0, tree::longest);
constexpr tree::Range anywhere = tree::within(-tree::farthest, tree::farthest);

/// Two numbers in `range`.
std::optional<Pair> read_pair(const json& value, const std::string& where, std::string_view names,
                              const tree::Range& range, std::string_view unit, Problems& problems) {
  if (!value.is_array() || value.size() != 2) {
    problems.push_back({where, fmt::format("must be {}", names)});
    return std::nullopt;
  }
  const auto a = tree::read_number(value[0], where + "/0", range, unit, problems);
  const auto b = tree::read_number(value[1], where + "/1", range, unit, problems);
  if (!a || !b) return std::nullopt;
  return Pair{*a, *b};
}

json pair_schema(const tree::Range& range, std::string_view unit) {
  return {{"type", "array"},
          {"items", tree::number_schema(range, unit)},
          {"minItems", 2},
          {"maxItems", 2}};
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::optional<Colour> read_colour(const json& value, const std::string& where, Problems& problems) {
  Colour colour{};
  const auto text = value.is_string() ? value.get_ref<const std::string&>() : std::string();
  bool right = text.size() == 7 && text[0] == '#';
  for (std::size_t i = 0; right && i < 3; ++i) {
    const int high = hex_digit(text[1 + 2 * i]), low = hex_digit(text[2 + 2 * i]);
    right = high >= 0 && low >= 0;
    colour[i] = static_cast<std::uint8_t>(right ? high * 16 + low : 0);
  }
  if (right) return colour;
  problems.push_back({where, "must be an sRGB colour as \"#rrggbb\""});
  return std::nullopt;
}
json colour_schema() { return {{"type", "string"}, {"pattern", "^#[0-9a-fA-F]{6}$"}}; }

std::optional<Pair> read_share(const json& value, const std::string& where, Problems& problems) {
  const auto pair =
      read_pair(value, where, "[low, high], each in [0, 1]", tree::within(0, 1), "1", problems);
  if (pair && (*pair)[0] > (*pair)[1]) {
    problems.push_back({where, fmt::format("must rise, got [{}, {}]", (*pair)[0], (*pair)[1])});
    return std::nullopt;
  }
  return pair;
}
json share_schema() { return pair_schema(tree::within(0, 1), "1"); }

std::optional<Pair> read_altitude(const json& value, const std::string& where, Problems& problems) {
  const auto pair = read_pair(value, where, "[low, high] in m", anywhere, "m", problems);
  if (pair && (*pair)[0] >= (*pair)[1]) {
    problems.push_back({where, fmt::format("must rise, got [{}, {}] m", (*pair)[0], (*pair)[1])});
    return std::nullopt;
  }
  return pair;
}
json altitude_schema() { return pair_schema(anywhere, "m"); }

std::optional<Pair> read_plan(const json& value, const std::string& where, Problems& problems) {
  return read_pair(value, where, "[x, y] in m", anywhere, "m", problems);
}
json plan_schema() { return pair_schema(anywhere, "m"); }

std::optional<tree::Polygon> read_outline(const json& value, const std::string& where,
                                          Problems& problems) {
  return tree::read_outline(value, where, 3, most_corners, problems);
}
json outline_schema() { return tree::outline_schema(3, most_corners); }

std::optional<std::optional<double>> read_fill(const json& value, const std::string& where,
                                               Problems& problems) {
  if (value == "hole") return std::optional<double>();
  if (!value.is_number()) {
    problems.push_back({where, "must be \"hole\" or an elevation in m"});
    return std::nullopt;
  }
  const auto fill = tree::read_number(value, where, anywhere, "m", problems);
  if (!fill) return std::nullopt;
  return fill;
}
json fill_schema() {
  return {{"anyOf", json::array({{{"const", "hole"}}, tree::number_schema(anywhere, "m")})},
          {"default", "hole"}};
}

std::optional<std::optional<Box>> read_extent(const json& value, const std::string& where,
                                              Problems& problems) {
  if (value.is_null()) return std::optional<Box>();
  if (!value.is_object()) {
    problems.push_back({where, "must be {\"min\": [x, y], \"max\": [x, y]} in m"});
    return std::nullopt;
  }
  static constexpr std::string_view keys[] = {"min", "max"};
  tree::report_unknown_keys(value, where, keys, problems);
  std::optional<Pair> corners[2];
  for (int i = 0; i < 2; ++i) {
    const auto at = fmt::format("{}/{}", where, keys[i]);
    const auto found = value.find(keys[i]);
    if (found == value.end()) {
      problems.push_back({at, "is missing"});
    } else {
      corners[i] = read_plan(*found, at, problems);
    }
  }
  if (!corners[0] || !corners[1]) return std::nullopt;
  const auto& [low, high] = corners;
  if ((*low)[0] >= (*high)[0] || (*low)[1] >= (*high)[1]) {
    problems.push_back({where, "\"min\" must be less than \"max\" in x and y"});
    return std::nullopt;
  }
  return std::optional<Box>(
      Box{{(*low)[0], (*low)[1], -Box::infinity}, {(*high)[0], (*high)[1], Box::infinity}});
}
json extent_schema() {
  return {{"type", {"object", "null"}},
          {"properties", {{"min", plan_schema()}, {"max", plan_schema()}}},
          {"required", {"min", "max"}},
          {"additionalProperties", false}};
}

std::optional<std::optional<double>> read_base(const json& value, const std::string& where,
                                               Problems& problems) {
  if (value.is_null()) return std::optional<double>();
  if (!value.is_object()) {
    problems.push_back({where, "must be {\"closed\": depth in m} or null"});
    return std::nullopt;
  }
  static constexpr std::string_view keys[] = {"closed"};
  tree::report_unknown_keys(value, where, keys, problems);
  const auto closed = value.find("closed");
  if (closed == value.end()) {
    problems.push_back({where + "/closed", "is missing"});
    return std::nullopt;
  }
  const auto depth = tree::read_number(*closed, where + "/closed", base_depth, "m", problems);
  if (!depth) return std::nullopt;
  return std::optional<double>(*depth);
}
json base_schema() {
  return {{"type", {"object", "null"}},
          {"properties", {{"closed", tree::number_schema(base_depth, "m")}}},
          {"required", {"closed"}},
          {"additionalProperties", false}};
}

std::optional<std::string> read_profile(const json& value, const std::string& where,
                                        Problems& problems) {
  const auto which = tree::read_choice(value, where, profiles, problems);
  if (!which) return std::nullopt;
  return std::string(profiles[*which]);
}
json profile_schema() { return {{"enum", profiles}, {"default", profiles[0]}}; }

std::optional<std::string> read_frame(const json& value, const std::string& where,
                                      Problems& problems) {
  const auto which = tree::read_choice(value, where, frames, problems);
  if (!which) return std::nullopt;
  return std::string(frames[*which]);
}
json frame_schema() { return {{"enum", frames}, {"default", frames[0]}}; }

}  // namespace hoodoo::scene::form
