#include "engine/tree/read_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/json.hpp"
#include "engine/tree/type_choice.hpp"

namespace hoodoo::tree {
namespace {

using nlohmann::json;

/// A value as a message shows it, cut where it is long.
std::string shown(const json& value) {
  std::string text = value.is_structured()
                         ? (value.is_array() ? "an array" : "an object")
                         : value.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

std::string shown(const Range& range, std::string_view unit) {
  return fmt::format("{}{}, {}]{}{}", range.open ? '(' : '[', range.low, range.high,
                     unit == "1" ? "" : " ", unit == "1" ? "" : unit);
}

/// Three numbers in `range`.
std::optional<Vec3> three_numbers(const json& value, const std::string& where, const Range& range,
                                  std::string_view unit, std::string_view what,
                                  Problems& problems) {
  if (!value.is_array() || value.size() != 3) {
    problems.push_back({where, fmt::format("must be {}, got {}", what, shown(value))});
    return std::nullopt;
  }
  Vec3 v;
  bool good = true;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = read_number(value[static_cast<std::size_t>(axis)],
                                    fmt::format("{}/{}", where, axis), range, unit, problems);
    if (number) {
      v[axis] = *number;
    } else {
      good = false;
    }
  }
  return good ? std::optional(v) : std::nullopt;
}

std::optional<Point> read_ground_point(const json& value, const std::string& where,
                                       Problems& problems) {
  static constexpr std::array<std::string_view, 3> keys{"xy", "uv", "ground"};
  const std::size_t before = problems.size();
  report_unknown_keys(value, where, keys, problems);
  const bool by_xy = value.contains("xy");
  if (by_xy == value.contains("uv")) {
    problems.push_back({where, "must have either \"xy\" or \"uv\" beside \"ground\""});
    return std::nullopt;
  }
  const std::string key = by_xy ? "xy" : "uv";
  const Range range = by_xy ? within(-farthest, farthest) : within(0, 1);
  const json& pair = value[key];
  Vec3 v;
  if (pair.is_array() && pair.size() == 2) {
    v.x =
        read_number(pair[0], fmt::format("{}/{}/0", where, key), range, by_xy ? "m" : "1", problems)
            .value_or(0);
    v.y =
        read_number(pair[1], fmt::format("{}/{}/1", where, key), range, by_xy ? "m" : "1", problems)
            .value_or(0);
  } else {
    problems.push_back({fmt::format("{}/{}", where, key),
                        fmt::format("must be two numbers, got {}", shown(pair))});
  }
  if (value.contains("ground")) {
    v.z =
        read_number(value["ground"], where + "/ground", within(-farthest, farthest), "m", problems)
            .value_or(0);
  } else {
    detail::missing(where, "ground", problems);
  }
  if (problems.size() != before) return std::nullopt;
  return Point(by_xy ? Point::Form::ground_xy : Point::Form::ground_uv, v);
}

std::optional<std::array<double, 2>> read_corner(const json& value, const std::string& where,
                                                 Problems& problems) {
  constexpr Range anywhere = within(-farthest, farthest);
  if (!value.is_array() || value.size() != 2) {
    problems.push_back({where, "must be [x, y] in m"});
    return std::nullopt;
  }
  const auto x = read_number(value[0], where + "/0", anywhere, "m", problems);
  const auto y = read_number(value[1], where + "/1", anywhere, "m", problems);
  if (!x || !y) return std::nullopt;
  return std::array{*x, *y};
}

/// Twice the signed area, about the first corner.
double doubled_area(const Polygon& corners) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto& a = corners[i];
    const auto& b = corners[(i + 1) % corners.size()];
    sum += (a[0] - corners[0][0]) * (b[1] - corners[0][1]) -
           (b[0] - corners[0][0]) * (a[1] - corners[0][1]);
  }
  return sum;
}

/// Of x, y, z, radius, energy.
/// Edits (insertions, deletions, replacements) that turn one word into the other.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::optional<double> read_number(const json& value, const std::string& where, const Range& range,
                                  std::string_view unit, Problems& problems) {
  if (!value.is_number()) {
    problems.push_back(
        {where, fmt::format("must be a number in {}, got {}", shown(range, unit), shown(value))});
    return std::nullopt;
  }
  const auto v = value.get<double>();
  if (!range.holds(v)) {
    problems.push_back({where, fmt::format("must be in {}, got {}", shown(range, unit), v)});
    return std::nullopt;
  }
  return v;
}

std::optional<long long> read_whole(const json& value, const std::string& where, long long low,
                                    long long high, Problems& problems) {
  // A real number without a fraction counts as whole, as JSON Schema has it.
  const auto v = value.is_number() ? value.get<double>() : std::nan("");
  if (!(v == std::floor(v))) {
    problems.push_back({where, fmt::format("must be a whole number in [{}, {}], got {}", low, high,
                                           shown(value))});
    return std::nullopt;
  }
  if (v < static_cast<double>(low) || v > static_cast<double>(high)) {
    problems.push_back(
        {where, fmt::format("must be in [{}, {}], got {}", low, high, shown(value))});
    return std::nullopt;
  }
  return value.is_number_integer() ? value.get<long long>() : static_cast<long long>(v);
}

std::optional<bool> read_flag(const json& value, const std::string& where, Problems& problems) {
  if (value.is_boolean()) return value.get<bool>();
  problems.push_back({where, fmt::format("must be true or false, got {}", shown(value))});
  return std::nullopt;
}

std::optional<std::string> read_text(const json& value, const std::string& where,
                                     Problems& problems) {
  if (value.is_string()) return value.get<std::string>();
  problems.push_back({where, fmt::format("must be a text, got {}", shown(value))});
  return std::nullopt;
}

std::optional<std::size_t> read_choice(const json& value, const std::string& where,
                                       std::span<const std::string_view> names,
                                       Problems& problems) {
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (value.is_string() && value.get_ref<const std::string&>() == names[i]) return i;
    all += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", names[i]);
  }
  problems.push_back({where, fmt::format("must be one of {}, got {}", all, shown(value))});
  return std::nullopt;
}

std::optional<Vec3> read_vector(const json& value, const std::string& where, const Range& range,
                                std::string_view unit, Problems& problems) {
  return three_numbers(value, where, range, unit, "three numbers", problems);
}

std::optional<Vec3> read_direction(const json& value, const std::string& where,
                                   Problems& problems) {
  const auto v =
      three_numbers(value, where, within(-farthest, farthest), "1", "three numbers", problems);
  if (v && !(length(*v) > 0)) {
    problems.push_back({where, "must not be [0, 0, 0]: it has no direction"});
    return std::nullopt;
  }
  return v;
}

std::optional<Point> read_point(const json& value, const std::string& where, Problems& problems) {
  if (value.is_object()) return read_ground_point(value, where, problems);
  const auto v = three_numbers(value, where, within(-farthest, farthest), "m",
                               "[x, y, z] or an object with \"ground\"", problems);
  return v ? std::optional(Point(*v)) : std::nullopt;
}

std::optional<std::vector<Point>> read_points(const json& value, const std::string& where,
                                              std::size_t least, std::size_t most,
                                              Problems& problems) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    problems.push_back(
        {where, fmt::format("must be an array of {} to {} points, got {}", least, most,
                            value.is_array() ? std::to_string(value.size()) : shown(value))});
    return std::nullopt;
  }
  std::vector<Point> points;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (auto p = read_point(value[i], fmt::format("{}/{}", where, i), problems)) {
      points.push_back(*p);
    }
  }
  return points.size() == value.size() ? std::optional(std::move(points)) : std::nullopt;
}

std::optional<Polygon> read_outline(const json& value, const std::string& where, std::size_t least,
                                    std::size_t most, Problems& problems) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    problems.push_back({where, fmt::format("must be {} to {} corners [x, y] in m", least, most)});
    return std::nullopt;
  }
  Polygon corners;
  bool good = true;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto corner = read_corner(value[i], fmt::format("{}/{}", where, i), problems);
    good = good && corner;
    if (corner) corners.push_back(*corner);
  }
  if (!good) return std::nullopt;
  if (doubled_area(corners) == 0) {
    problems.push_back({where, "encloses no area"});
    return std::nullopt;
  }
  return corners;
}

std::optional<Balls> read_balls(const json& value, const std::string& where, std::size_t least,
                                std::size_t most, Problems& problems) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    problems.push_back(
        {where, fmt::format("must be an array of {} to {} balls, got {}", least, most,
                            value.is_array() ? std::to_string(value.size()) : shown(value))});
    return std::nullopt;
  }
  const std::size_t before = problems.size();
  std::vector<Ball> balls;
  balls.reserve(value.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    const json& one = value[i];
    const std::string at = fmt::format("{}/{}", where, i);
    if (!one.is_array() || one.size() < 4 || one.size() > 5) {
      problems.push_back({at, fmt::format("must be [x, y, z, radius] or [x, y, z, radius, energy], "
                                          "got {}",
                                          shown(one))});
      continue;
    }
    std::array<double, 5> numbers{0, 0, 0, 1, 1};
    for (std::size_t k = 0; k < one.size(); ++k) {
      numbers[k] = read_number(one[k], fmt::format("{}/{}", at, k), ball_ranges[k],
                               k < 4 ? "m" : "1", problems)
                       .value_or(1);
    }
    const auto [x, y, z, radius, energy] = numbers;
    balls.push_back({{x, y, z}, radius, static_cast<float>(energy)});
  }
  return problems.size() == before ? std::optional(Balls(balls)) : std::nullopt;
}

void report_unknown_keys(const json& object, const std::string& where,
                         std::span<const std::string_view> known, Problems& problems) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string_view near = nearest(key, known);
    const std::string hint = near.empty() ? "" : fmt::format(", did you mean \"{}\"?", near);
    problems.push_back(
        {fmt::format("{}/{}", where, pointer_token(key)), "is not a known key" + hint});
  }
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> known) {
  if (word.size() > 40) return "";
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t n = edits(word, candidate);
    if (n < least) {
      least = n;
      best = candidate;
    }
  }
  return best;
}

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

json to_json(const Point& p) {
  if (p.form == Point::Form::fixed) return to_json(p.value);
  const char* key = p.form == Point::Form::ground_xy ? "xy" : "uv";
  return {{key, json::array({p.value.x, p.value.y})}, {"ground", p.value.z}};
}

json to_json(const Balls& balls) {
  json list = json::array();
  for (const Ball& b : balls.list()) {
    list.push_back({b.center.x, b.center.y, b.center.z, b.radius, static_cast<double>(b.energy)});
  }
  return list;
}

json number_schema(const Range& range, std::string_view unit) {
  json schema{{"type", "number"}, {"maximum", range.high}};
  schema[range.open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (unit != "1") schema["x-unit"] = std::string(unit);
  return schema;
}

json vector_schema(const Range& range, std::string_view unit) {
  return {
      {"type", "array"}, {"items", number_schema(range, unit)}, {"minItems", 3}, {"maxItems", 3}};
}

json outline_schema(std::size_t least, std::size_t most) {
  return {{"type", "array"},
          {"items",
           {{"type", "array"},
            {"items", number_schema(within(-farthest, farthest), "m")},
            {"minItems", 2},
            {"maxItems", 2}}},
          {"minItems", least},
          {"maxItems", most}};
}

json balls_schema(std::size_t least, std::size_t most) {
  json numbers = json::array();
  for (std::size_t k = 0; k < ball_ranges.size(); ++k) {
    numbers.push_back(number_schema(ball_ranges[k], k < 4 ? "m" : "1"));
  }
  const json ball{{"type", "array"}, {"prefixItems", numbers}, {"minItems", 4}, {"maxItems", 5}};
  return {{"type", "array"}, {"items", ball}, {"minItems", least}, {"maxItems", most}};
}

json point_schema() { return {{"$ref", "#/$defs/point"}}; }

json point_definition() {
  const auto pair = [](const Range& range, std::string_view unit) {
    return json{
        {"type", "array"}, {"items", number_schema(range, unit)}, {"minItems", 2}, {"maxItems", 2}};
  };
  const json ground{{"type", "object"},
                    {"properties",
                     {{"xy", pair(within(-farthest, farthest), "m")},
                      {"uv", pair(within(0, 1), "1")},
                      {"ground", number_schema(within(-farthest, farthest), "m")}}},
                    {"required", {"ground"}},
                    {"oneOf", each_required({"xy", "uv"})},
                    {"additionalProperties", false}};
  return {{"description",
           "A place: [x, y, z] in metres, or a height over the input terrain at xy in metres or at "
           "uv, a fraction of the first terrain's extent."},
          {"if", {{"type", "object"}}},
          {"then", ground},
          {"else", vector_schema(within(-farthest, farthest), "m")}};
}

}  // namespace hoodoo::tree
