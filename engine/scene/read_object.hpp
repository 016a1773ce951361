#pragma once
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "engine/scene/fields.hpp"
#include "engine/tree/read_fields.hpp"
#include "engine/tree/type_choice.hpp"

/// JSON in, and schema out, of settings that list their fields.
namespace hoodoo::scene {

using tree::Problems;

namespace detail {

template <class T, class Field>
void read(const Field& f, const nlohmann::json& object, const std::string& where, T& into,
          Problems& problems) {
  tree::detail::read(f, object, where, into, problems);
}
template <class T, class V>
void read(const Special<T, V>& f, const nlohmann::json& object, const std::string& where, T& into,
          Problems& problems) {
  tree::detail::read_one(object, where, f.key, into.*f.member, f.fallback, problems,
                         [&](const nlohmann::json& json, const std::string& at) {
                           return f.form.read(json, at, problems);
                         });
}

template <class Field>
nlohmann::json schema(const Field& f) {
  auto one = tree::detail::schema(f);
  tree::detail::put_fallback(f, one);
  return one;
}
template <class T, class V>
nlohmann::json schema(const Special<T, V>& f) {
  return f.form.schema();
}
template <class Field>
bool is_required(const Field& f) {
  return tree::detail::is_required(f);
}
template <class T, class V>
bool is_required(const Special<T, V>& f) {
  return !f.fallback.has_value();
}

}  // namespace detail

/// Reads the fields of T; `others` are keys that the caller reads. Problems as tree::read_fields,
/// and a key that is in neither list.
template <class T>
void read_object(const nlohmann::json& object, const std::string& where, T& into,
                 Problems& problems, std::vector<std::string_view> others = {}) {
  if (!object.is_object()) {
    problems.push_back({where, "must be an object"});
    return;
  }
  const auto before = problems.size();
  std::apply([&](const auto&... f) { (detail::read(f, object, where, into, problems), ...); },
             T::fields());
  if constexpr (requires { into.check(where, problems); }) {
    if (problems.size() == before) into.check(where, problems);
  }
  const auto own = tree::field_keys<T>();
  others.insert(others.end(), own.begin(), own.end());
  tree::report_unknown_keys(object, where, others, problems);
}

/// The schema of such an object; callers add the properties of `others`.
template <class T>
nlohmann::json object_schema() {
  auto properties = nlohmann::json::object();
  auto needed = nlohmann::json::array();
  const auto put = [&](const auto& f) {
    auto one = detail::schema(f);
    one["description"] = std::string(f.doc);
    if (detail::is_required(f)) needed.push_back(std::string(f.key));
    properties[std::string(f.key)] = std::move(one);
  };
  std::apply([&](const auto&... f) { (put(f), ...); }, T::fields());
  nlohmann::json object = {
      {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (!needed.empty()) object["required"] = std::move(needed);
  return object;
}

/// A list of types that a "type" key tells apart: std::variant of structs with `type`, `doc` and
/// `fields()`.
template <class Any>
struct Types;

template <class... T>
struct Types<std::variant<T...>> {
  using Any = std::variant<T...>;

  static std::vector<std::string_view> names() { return {T::type...}; }

  /// Reads the type that object["type"] names. None, with problems added, when there is no such.
  static std::optional<Any> read(const nlohmann::json& object, const std::string& where,
                                 Problems& problems, std::vector<std::string_view> others = {}) {
    if (!object.is_object()) {
      problems.push_back({where, "must be an object"});
      return std::nullopt;
    }
    const auto type = object.find("type");
    if (type == object.end()) {
      problems.push_back({where + "/type", fmt::format("is missing: {}", listed())});
      return std::nullopt;
    }
    const auto name = tree::read_text(*type, where + "/type", problems);
    if (!name) return std::nullopt;
    others.push_back("type");
    std::optional<Any> made;
    const auto take = [&](auto one) {
      if (*name != decltype(one)::type) return;
      read_object(object, where, one, problems, others);
      made = std::move(one);
    };
    (take(T{}), ...);
    if (!made) report_unknown(*name, where, problems);
    return made;
  }

  /// One definition per type, "<prefix>.<type>", put into `definitions`; a schema for any of them.
  static nlohmann::json schema(const std::string& prefix, nlohmann::json& definitions,
                               const nlohmann::json& others = nlohmann::json::object()) {
    tree::TypeChoice choice;
    const auto put = [&](std::string_view type, std::string_view doc, nlohmann::json one) {
      one["description"] = std::string(doc);
      one["properties"]["type"] = {{"const", std::string(type)}};
      one["properties"].update(others);
      auto needed = one.value("required", nlohmann::json::array());
      needed.insert(needed.begin(), "type");
      one["required"] = std::move(needed);
      const auto name = fmt::format("{}.{}", prefix, type);
      choice.add(type, name);
      definitions[name] = std::move(one);
    };
    const auto cite = []<class One>(std::type_identity<One>, nlohmann::json one) {
      if constexpr (requires { One::cited; }) {
        one["$comment"] = fmt::format("Source: {}.", One::cited);
      }
      return one;
    };
    (put(T::type, T::doc, cite(std::type_identity<T>(), object_schema<T>())), ...);
    auto any = choice.schema();
    any["type"] = "object";
    any["required"] = nlohmann::json::array({"type"});
    return any;
  }

 private:
  static std::string listed() {
    std::string text = "one of";
    ((text += fmt::format(" \"{}\",", T::type)), ...);
    text.pop_back();
    return text;
  }
  static void report_unknown(const std::string& name, const std::string& where,
                             Problems& problems) {
    const auto near = tree::nearest(name, names());
    problems.push_back({where + "/type", near.empty() ? fmt::format("must be {}", listed())
                                                      : fmt::format("is unknown: did you mean "
                                                                    "\"{}\"?",
                                                                    near)});
  }
};

}  // namespace hoodoo::scene
