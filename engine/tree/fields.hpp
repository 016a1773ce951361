#pragma once
#include <concepts>
#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "engine/base/error.hpp"
#include "engine/base/vector.hpp"
#include "engine/tree/balls.hpp"
#include "engine/tree/point.hpp"
#include "engine/tree/polygon.hpp"

/// Descriptors of what a scene author may set on a type. A type lists them once, in a static
/// `fields()` that returns a tuple; parser, canonical JSON, schema and reference page derive from
/// that list (read_fields.hpp). Nodes, brushes and settings all use them.
namespace hoodoo::tree {

/// Accepted numbers: [low, high], or (low, high] where `open`.
struct Range {
  double low, high;
  bool open = false;
  constexpr bool holds(double v) const { return (open ? v > low : v >= low) && v <= high; }
};
constexpr Range within(double low, double high) { return {low, high, false}; }
constexpr Range above(double low, double high) { return {low, high, true}; }

/// In place of a fallback: the key must be there.
inline constexpr std::nullopt_t required = std::nullopt;

inline constexpr double longest = 1e5;   // [m] the largest size of a thing
inline constexpr double farthest = 1e8;  // [m] the largest coordinate

template <class T>
struct Number {
  std::string_view key;            // JSON key
  double T::*member;               // where it lands
  std::string_view unit;           // "m", "deg", "1"
  Range range;                     // accepted
  std::optional<double> fallback;  // value when the key is absent
  std::string_view doc;            // one line
};

/// A number that may be left out, and then has no value.
template <class T>
struct OptionalNumber {
  std::string_view key;
  std::optional<double> T::*member;
  std::string_view unit;
  Range range;
  std::string_view doc;
};

template <class T, std::integral I = int>
struct Whole {
  std::string_view key;
  I T::*member;
  long long low, high;
  std::optional<I> fallback;
  std::string_view doc;
};

template <class T>
struct Flag {
  std::string_view key;
  bool T::*member;
  bool fallback;
  std::string_view doc;
};

/// One of a list of names; the value of E is its place in the list.
template <class T, class E>
struct Choice {
  std::string_view key;
  E T::*member;
  std::span<const std::string_view> names;
  std::optional<E> fallback;
  std::string_view doc;
};

template <class T>
struct Text {
  std::string_view key;
  std::string T::*member;
  std::optional<std::string_view> fallback;
  std::string_view doc;
};

template <class T>
struct Position {
  std::string_view key;
  Point T::*member;
  std::optional<Vec3> fallback;
  std::string_view doc;
};

template <class T>
struct Positions {
  std::string_view key;
  std::vector<Point> T::*member;
  std::size_t least, most;
  std::string_view doc;
};

/// A polygon in plan: corners [x, y] [m] that enclose an area.
template <class T>
struct Outline {
  std::string_view key;
  Polygon T::*member;
  std::size_t least, most;  // corners
  std::string_view doc;
};

inline constexpr std::size_t most_balls = 1'000'000;  // of a list in the scene itself

/// Balls, each an array of numbers.
template <class T>
struct BallList {
  std::string_view key;
  Balls T::*member;
  std::size_t fewest, most;  // none: they are in a file
  std::string_view doc;
};

/// Name of a file that is read instead; "" where there is none.
template <class T>
struct FileName {
  std::string_view key;
  std::string T::*member;
  std::string_view doc;
};

/// Three numbers, each in `range`.
template <class T>
struct Vector {
  std::string_view key;
  Vec3 T::*member;
  std::string_view unit;
  Range range;
  std::optional<Vec3> fallback;
  std::string_view doc;
};

/// Three numbers, not all 0; only the direction counts.
template <class T>
struct Direction {
  std::string_view key;
  Vec3 T::*member;
  std::optional<Vec3> fallback;
  std::string_view doc;
};

/// An object with fields of its own, each with a fallback, so that it may be left out.
template <class T, class G>
struct Group {
  std::string_view key;
  G T::*member;
  std::string_view doc;
};

/// An object of numbers under names of the author's choice; empty where it is left out.
template <class T>
struct Numbers {
  std::string_view key;
  std::map<std::string, double> T::*member;
  std::size_t most;
  Range range;
  std::string_view doc;
};

/// A list of objects with fields of their own.
template <class T, class G>
struct Groups {
  std::string_view key;
  std::vector<G> T::*member;
  std::size_t least, most;
  std::string_view doc;
};

/// A value with a JSON form of its own.
template <class V>
struct Form {
  /// None, and a problem at `where`, when `json` is not such a value.
  std::optional<V> (*read)(const nlohmann::json& json, const std::string& where,
                           std::vector<Problem>& problems);
  nlohmann::json (*schema)();
};

/// A field whose value has such a form.
template <class T, class V>
struct Special {
  std::string_view key;
  V T::*member;
  Form<V> form;
  std::optional<V> fallback;  // required: the key must be there
  std::string_view doc;
};

}  // namespace hoodoo::tree
