#pragma once
#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/json.hpp"
#include "engine/tree/fields.hpp"

/// JSON in and out of any type that lists its fields.
namespace hoodoo::tree {

using Problems = std::vector<Problem>;

// One value each: none, and a problem at `where`, when `json` is not one.
std::optional<double> read_number(const nlohmann::json& json, const std::string& where,
                                  const Range& range, std::string_view unit, Problems& problems);
std::optional<long long> read_whole(const nlohmann::json& json, const std::string& where,
                                    long long low, long long high, Problems& problems);
std::optional<bool> read_flag(const nlohmann::json& json, const std::string& where,
                              Problems& problems);
std::optional<std::string> read_text(const nlohmann::json& json, const std::string& where,
                                     Problems& problems);
std::optional<std::size_t> read_choice(const nlohmann::json& json, const std::string& where,
                                       std::span<const std::string_view> names, Problems& problems);
std::optional<Vec3> read_vector(const nlohmann::json& json, const std::string& where,
                                const Range& range, std::string_view unit, Problems& problems);
std::optional<Vec3> read_direction(const nlohmann::json& json, const std::string& where,
                                   Problems& problems);
std::optional<Point> read_point(const nlohmann::json& json, const std::string& where,
                                Problems& problems);
std::optional<std::vector<Point>> read_points(const nlohmann::json& json, const std::string& where,
                                              std::size_t least, std::size_t most,
                                              Problems& problems);
std::optional<Polygon> read_outline(const nlohmann::json& json, const std::string& where,
                                    std::size_t least, std::size_t most, Problems& problems);
/// x, y, z [m], radius [m] and energy [1] of a ball.
inline constexpr std::array<Range, 5> ball_ranges{
    within(-farthest, farthest), within(-farthest, farthest), within(-farthest, farthest),
    above(0, longest), within(-1000, 1000)};
std::optional<Balls> read_balls(const nlohmann::json& json, const std::string& where,
                                std::size_t least, std::size_t most, Problems& problems);

/// A problem for every key of `object` that is not in `known`, naming the nearest that is.
void report_unknown_keys(const nlohmann::json& object, const std::string& where,
                         std::span<const std::string_view> known, Problems& problems);
/// The nearest of `known` to `word`; "" when none is near.
std::string_view nearest(std::string_view word, std::span<const std::string_view> known);

nlohmann::json to_json(const Vec3& v);
nlohmann::json to_json(const Point& p);
nlohmann::json to_json(const Balls& balls);

// JSON Schema of one value.
nlohmann::json number_schema(const Range& range, std::string_view unit);
nlohmann::json vector_schema(const Range& range, std::string_view unit);
nlohmann::json outline_schema(std::size_t least, std::size_t most);
nlohmann::json balls_schema(std::size_t least, std::size_t most);
nlohmann::json point_schema();  // a reference to #/$defs/point
nlohmann::json point_definition();

/// The keys that T lists.
template <class T>
std::vector<std::string_view> field_keys() {
  return std::apply([](const auto&... f) { return std::vector<std::string_view>{f.key...}; },
                    T::fields());
}

/// Reads the fields of T, giving absent ones their fallback. Every problem is added to `problems`:
/// a missing required key, a wrong type, a number out of range, and, through T::check where T has
/// it, fields that contradict each other. Unknown keys are the caller's (report_unknown_keys),
/// who knows what else the object may hold.
template <class T>
void read_fields(const nlohmann::json& object, const std::string& where, T& into,
                 Problems& problems);
/// Puts every field of T into `object`, those with their fallback too.
template <class T>
void write_fields(const T& from, nlohmann::json& object);
/// {"properties": {...}, "required": [...]}.
template <class T>
nlohmann::json fields_schema();

namespace detail {

inline void missing(const std::string& where, std::string_view key, Problems& problems) {
  problems.push_back({fmt::format("{}/{}", where, key), "is missing"});
}

/// Stores `read(value)` or the fallback; a required key that is absent is a problem.
template <class Value, class Fallback, class Read>
void read_one(const nlohmann::json& object, const std::string& where, std::string_view key,
              Value& into, const Fallback& fallback, Problems& problems, Read read) {
  const auto found = object.find(key);
  if (found == object.end()) {
    if (fallback) {
      into = static_cast<Value>(*fallback);
    } else {
      missing(where, key, problems);
    }
    return;
  }
  if (auto value = read(*found, fmt::format("{}/{}", where, key))) {
    into = static_cast<Value>(*std::move(value));
  }
}

template <class T>
void read(const Number<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p, [&](const auto& json, const auto& at) {
    return read_number(json, at, f.range, f.unit, p);
  });
}
template <class T>
void read(const OptionalNumber<T>& f, const nlohmann::json& o, const std::string& w, T& t,
          Problems& p) {
  const auto found = o.find(f.key);
  t.*f.member = std::nullopt;
  if (found == o.end() || found->is_null()) return;
  t.*f.member = read_number(*found, fmt::format("{}/{}", w, f.key), f.range, f.unit, p);
}
template <class T, class I>
void read(const Whole<T, I>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p, [&](const auto& json, const auto& at) {
    return read_whole(json, at, f.low, f.high, p);
  });
}
template <class T>
void read(const Flag<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, std::optional<bool>(f.fallback), p,
           [&](const auto& json, const auto& at) { return read_flag(json, at, p); });
}
template <class T, class E>
void read(const Choice<T, E>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p,
           [&](const auto& json, const auto& at) { return read_choice(json, at, f.names, p); });
}
template <class T>
void read(const Text<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p,
           [&](const auto& json, const auto& at) { return read_text(json, at, p); });
}
template <class T>
void read(const Position<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p,
           [&](const auto& json, const auto& at) { return read_point(json, at, p); });
}
template <class T>
void read(const Positions<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  std::optional<std::vector<Point>> none;
  if (f.least == 0) none.emplace();
  read_one(o, w, f.key, t.*f.member, none, p, [&](const auto& json, const auto& at) {
    return read_points(json, at, f.least, f.most, p);
  });
}
template <class T>
void read(const Outline<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(
      o, w, f.key, t.*f.member, std::optional<Polygon>(), p,
      [&](const auto& json, const auto& at) { return read_outline(json, at, f.least, f.most, p); });
}
template <class T>
void read(const BallList<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(
      o, w, f.key, t.*f.member, std::optional<Balls>(Balls()), p,
      [&](const auto& json, const auto& at) { return read_balls(json, at, f.fewest, f.most, p); });
}
template <class T>
void read(const FileName<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, std::optional<std::string>(""), p,
           [&](const auto& json, const auto& at) { return read_text(json, at, p); });
}
template <class T>
void read(const Vector<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p, [&](const auto& json, const auto& at) {
    return read_vector(json, at, f.range, f.unit, p);
  });
}
template <class T>
void read(const Direction<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  read_one(o, w, f.key, t.*f.member, f.fallback, p,
           [&](const auto& json, const auto& at) { return read_direction(json, at, p); });
}
template <class T, class G>
void read(const Group<T, G>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  const auto found = o.find(f.key);
  const auto at = fmt::format("{}/{}", w, f.key);
  if (found != o.end() && !found->is_object()) {
    p.push_back({at, "must be an object"});
    return;
  }
  static const nlohmann::json nothing = nlohmann::json::object();
  const nlohmann::json& object = found == o.end() ? nothing : *found;
  read_fields(object, at, t.*f.member, p);
  report_unknown_keys(object, at, field_keys<G>(), p);
}
template <class T, class G>
void read(const Groups<T, G>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  const auto found = o.find(f.key);
  if (found == o.end()) return missing(w, f.key, p);
  const auto at = fmt::format("{}/{}", w, f.key);
  if (!found->is_array() || found->size() < f.least || found->size() > f.most) {
    p.push_back({at, fmt::format("must be an array of {} to {} objects", f.least, f.most)});
    return;
  }
  (t.*f.member).assign(found->size(), G());
  for (std::size_t i = 0; i < found->size(); ++i) {
    const auto& one = (*found)[i];
    const auto place = fmt::format("{}/{}", at, i);
    if (!one.is_object()) {
      p.push_back({place, "must be an object"});
      continue;
    }
    read_fields(one, place, (t.*f.member)[i], p);
    report_unknown_keys(one, place, field_keys<G>(), p);
  }
}

template <class T>
void read(const Numbers<T>& f, const nlohmann::json& o, const std::string& w, T& t, Problems& p) {
  (t.*f.member).clear();
  const auto found = o.find(f.key);
  if (found == o.end()) return;
  const auto at = fmt::format("{}/{}", w, f.key);
  if (!found->is_object() || found->size() > f.most) {
    p.push_back({at, fmt::format("must be an object of at most {} numbers", f.most)});
    return;
  }
  for (const auto& [name, value] : found->items()) {
    const auto number =
        read_number(value, fmt::format("{}/{}", at, pointer_token(name)), f.range, "1", p);
    if (number) (t.*f.member)[name] = *number;
  }
}

template <class V>
inline constexpr bool is_list_of_groups = false;
template <class G>
inline constexpr bool is_list_of_groups<std::vector<G>> = requires {
  G::fields();
};

template <class T, class Field>
nlohmann::json write(const Field& f, const T& t) {
  const auto& value = t.*f.member;
  using Value = std::remove_cvref_t<decltype(value)>;
  if constexpr (std::is_same_v<Value, Vec3> || std::is_same_v<Value, Point> ||
                std::is_same_v<Value, Balls>) {
    return to_json(value);
  } else if constexpr (std::is_same_v<Value, std::vector<Point>>) {
    auto list = nlohmann::json::array();
    for (const Point& p : value) list.push_back(to_json(p));
    return list;
  } else if constexpr (is_list_of_groups<Value>) {
    auto list = nlohmann::json::array();
    for (const auto& one : value) {
      auto object = nlohmann::json::object();
      write_fields(one, object);
      list.push_back(std::move(object));
    }
    return list;
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return value ? nlohmann::json(*value) : nlohmann::json();
  } else if constexpr (std::is_enum_v<Value>) {
    return std::string(f.names[static_cast<std::size_t>(value)]);
  } else if constexpr (requires { Value::fields(); }) {
    auto object = nlohmann::json::object();
    write_fields(value, object);
    return object;
  } else {
    return value;
  }
}

template <class T>
nlohmann::json schema(const Number<T>& f) {
  return number_schema(f.range, f.unit);
}
template <class T>
nlohmann::json schema(const OptionalNumber<T>& f) {
  auto number = number_schema(f.range, f.unit);
  number["type"] = {"number", "null"};
  return number;
}
template <class T, class I>
nlohmann::json schema(const Whole<T, I>& f) {
  return {{"type", "integer"}, {"minimum", f.low}, {"maximum", f.high}};
}
template <class T>
nlohmann::json schema(const Flag<T>&) {
  return {{"type", "boolean"}};
}
template <class T, class E>
nlohmann::json schema(const Choice<T, E>& f) {
  auto names = nlohmann::json::array();
  for (const auto name : f.names) names.push_back(std::string(name));
  return {{"enum", names}};
}
template <class T>
nlohmann::json schema(const Text<T>&) {
  return {{"type", "string"}};
}
template <class T>
nlohmann::json schema(const Position<T>&) {
  return point_schema();
}
template <class T>
nlohmann::json schema(const Positions<T>& f) {
  return {
      {"type", "array"}, {"items", point_schema()}, {"minItems", f.least}, {"maxItems", f.most}};
}
template <class T>
nlohmann::json schema(const Outline<T>& f) {
  return outline_schema(f.least, f.most);
}
template <class T>
nlohmann::json schema(const BallList<T>& f) {
  return balls_schema(f.fewest, f.most);
}
template <class T>
nlohmann::json schema(const FileName<T>&) {
  return {{"type", "string"}};
}
template <class T>
nlohmann::json schema(const Vector<T>& f) {
  return vector_schema(f.range, f.unit);
}
template <class T>
nlohmann::json schema(const Direction<T>&) {
  return vector_schema(within(-farthest, farthest), "1");
}
template <class T, class G>
nlohmann::json schema(const Group<T, G>&) {
  nlohmann::json object = fields_schema<G>();
  object["type"] = "object";
  object["additionalProperties"] = false;
  return object;
}

template <class T, class G>
nlohmann::json schema(const Groups<T, G>& f) {
  nlohmann::json object = fields_schema<G>();
  object["type"] = "object";
  object["additionalProperties"] = false;
  return {{"type", "array"}, {"items", object}, {"minItems", f.least}, {"maxItems", f.most}};
}

template <class T>
nlohmann::json schema(const Numbers<T>& f) {
  return {{"type", "object"},
          {"additionalProperties", number_schema(f.range, "1")},
          {"maxProperties", f.most}};
}

/// A field without a fallback must be there, but for lists of points that may be empty.
template <class Field>
constexpr bool is_required(const Field& f) {
  if constexpr (requires { f.fallback.has_value(); }) {
    return !f.fallback.has_value();
  } else if constexpr (requires { f.least; }) {
    return f.least > 0;
  } else {
    return false;
  }
}

template <class Field>
void put_fallback(const Field& f, nlohmann::json& schema) {
  if constexpr (requires { f.names; }) {
    if (f.fallback) schema["default"] = std::string(f.names[static_cast<std::size_t>(*f.fallback)]);
  } else if constexpr (requires { f.fallback.has_value(); }) {
    using Value = std::remove_cvref_t<decltype(*f.fallback)>;
    if (!f.fallback) return;
    if constexpr (std::is_same_v<Value, Vec3>) {
      schema["default"] = to_json(*f.fallback);
    } else {
      schema["default"] = *f.fallback;
    }
  } else if constexpr (requires { f.fallback; }) {
    schema["default"] = f.fallback;
  }
}

}  // namespace detail

template <class T>
void read_fields(const nlohmann::json& object, const std::string& where, T& into,
                 Problems& problems) {
  const std::size_t before = problems.size();
  std::apply([&](const auto&... f) { (detail::read(f, object, where, into, problems), ...); },
             T::fields());
  if constexpr (requires { into.check(where, problems); }) {
    if (problems.size() == before) into.check(where, problems);
  }
}

template <class T>
void write_fields(const T& from, nlohmann::json& object) {
  std::apply(
      [&](const auto&... f) { ((object[std::string(f.key)] = detail::write(f, from)), ...); },
      T::fields());
}

template <class T>
nlohmann::json fields_schema() {
  auto properties = nlohmann::json::object();
  auto needed = nlohmann::json::array();
  const auto put = [&](const auto& f) {
    nlohmann::json one = detail::schema(f);
    one["description"] = std::string(f.doc);
    detail::put_fallback(f, one);
    if (detail::is_required(f)) needed.push_back(std::string(f.key));
    properties[std::string(f.key)] = std::move(one);
  };
  std::apply([&](const auto&... f) { (put(f), ...); }, T::fields());
  return {{"properties", std::move(properties)}, {"required", std::move(needed)}};
}

}  // namespace hoodoo::tree
