#include "engine/tree/packed_trees.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include "engine/tree/composite.hpp"

namespace hoodoo::tree {
namespace {

using Bytes = std::vector<std::byte>;

/// What a value may be made of to be packed: numbers, places, and objects with fields of such.
template <class T>
inline constexpr bool is_plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class M, class T>
M type_of_member(M T::*);
template <class F>
using FieldValue = decltype(type_of_member(std::declval<F>().member));

template <class T>
constexpr bool has_form();
template <class... F>
constexpr bool have_forms(const std::tuple<F...>*) {
  return (has_form<FieldValue<F>>() && ...);
}
template <class T>
constexpr bool has_form() {
  if constexpr (requires { T::fields(); }) {
    return have_forms(static_cast<const decltype(T::fields())*>(nullptr));
  } else {
    return is_plain<T> || std::is_same_v<T, Vec3> || std::is_same_v<T, Point> ||
           std::is_same_v<T, std::optional<double>> || std::is_same_v<T, std::vector<Point>>;
  }
}

template <class T>
constexpr std::size_t mask_bytes() {
  return (std::tuple_size_v<decltype(T::fields())> + 7) / 8;
}

class Writer {
 public:
  explicit Writer(Bytes& out) : out_(&out) {}

  /// False where it has no packed form.
  bool put(const Node& tree) {
    put(static_cast<std::uint8_t>(tree.value.index()));
    const bool done = std::visit(
        [&]<class N>(const N& node) {
          if constexpr (has_form<N>()) {
            put_fields(node);
            return true;
          } else {
            return false;
          }
        },
        tree.value);
    if (!done) return false;
    put_count(tree.children.size());
    return std::ranges::all_of(tree.children, [&](const Node& child) { return put(child); });
  }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (is_plain<T>) {
      const auto at = out_->size();
      out_->resize(at + sizeof(T));
      std::memcpy(out_->data() + at, &value, sizeof(T));
    } else {
      put_fields(value);
    }
  }
  void put(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) put(v[axis]);
  }
  void put(const Point& p) {
    put(static_cast<std::uint8_t>(p.form));
    put(p.value);
  }
  void put(const std::optional<double>& v) {
    put(v.has_value());
    put(v.value_or(0));
  }
  void put(const std::vector<Point>& all) {
    put_count(all.size());
    for (const Point& p : all) put(p);
  }
  void put_count(std::size_t n) {
    for (; n >= 128; n /= 128) put(static_cast<std::uint8_t>(n % 128 + 128));
    put(static_cast<std::uint8_t>(n));
  }
  /// A bit for each field that has other bits than in a new T, then those fields.
  template <class T>
  void put_fields(const T& from) {
    const T standard{};
    const auto mask = out_->size();
    out_->resize(mask + mask_bytes<T>());
    std::size_t i = 0;
    const auto put_one = [&](const auto& field) {
      const auto at = out_->size();
      put(from.*field.member);
      const auto end = out_->size();
      put(standard.*field.member);
      const auto* bytes = out_->data();
      const bool same = std::equal(bytes + at, bytes + end, bytes + end, bytes + out_->size());
      out_->resize(same ? at : end);
      if (!same) (*out_)[mask + i / 8] |= std::byte{1} << (i % 8);
      ++i;
    };
    std::apply([&](const auto&... f) { (put_one(f), ...); }, T::fields());
  }

  Bytes* out_;
};

class Reader {
 public:
  explicit Reader(const std::byte* at) : at_(at) {}

  Node node() { return node(static_cast<AnyNode*>(nullptr)); }

 private:
  template <class... N>
  Node node(std::variant<N...>*) {
    static_assert(sizeof...(N) < 256);
    std::uint8_t index = 0;
    get(index);
    Node made{Blend{}, {}};
    std::uint8_t i = 0;
    const auto is_this = [&]<class One>(const One*) {
      if (i++ != index) return false;
      if constexpr (has_form<One>()) {
        One value;
        get_fields(value);
        made.value = std::move(value);
      }
      return true;
    };
    (is_this(static_cast<const N*>(nullptr)) || ...);
    made.children.resize(count(), Node{Blend{}, {}});
    for (Node& child : made.children) child = node();
    return made;
  }
  template <class T>
  void get(T& into) {
    if constexpr (is_plain<T>) {
      std::memcpy(&into, at_, sizeof(T));
      at_ += sizeof(T);
    } else {
      get_fields(into);
    }
  }
  void get(Vec3& v) { get(v.x), get(v.y), get(v.z); }
  void get(Point& p) {
    std::uint8_t form = 0;
    get(form);
    p.form = static_cast<Point::Form>(form);
    get(p.value);
  }
  void get(std::optional<double>& v) {
    bool any = false;
    double number = 0;
    get(any), get(number);
    v = any ? std::optional(number) : std::nullopt;
  }
  void get(std::vector<Point>& all) {
    all.resize(count());
    for (Point& p : all) get(p);
  }
  std::size_t count() {
    std::size_t n = 0;
    for (unsigned shift = 0;; shift += 7) {
      std::uint8_t part = 0;
      get(part);
      n |= std::size_t{part & 127U} << shift;
      if (part < 128) return n;
    }
  }
  template <class T>
  void get_fields(T& into) {
    const std::byte* mask = at_;
    at_ += mask_bytes<T>();
    std::size_t i = 0;
    const auto get_one = [&](const auto& field) {
      if ((mask[i / 8] >> (i % 8) & std::byte{1}) != std::byte{0}) get(into.*field.member);
      ++i;
    };
    std::apply([&](const auto&... f) { (get_one(f), ...); }, T::fields());
  }

  const std::byte* at_;
};

/// A box of half the size that holds the other.
struct Outside {
  std::array<float, 3> low, high;

  explicit Outside(const Box& box) {
    constexpr float far = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      low[a] = static_cast<float>(box.min[axis]);
      if (static_cast<double>(low[a]) > box.min[axis]) low[a] = std::nextafter(low[a], -far);
      high[a] = static_cast<float>(box.max[axis]);
      if (static_cast<double>(high[a]) < box.max[axis]) high[a] = std::nextafter(high[a], far);
    }
  }
  Box box() const { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }
};

}  // namespace

struct PackedTrees::Data {
  Bytes bytes;
  std::vector<std::uint32_t> starts;
  std::vector<Outside> boxes;
  std::size_t nodes = 0;
  Support support;
};

std::optional<PackedTrees> PackedTrees::of(const std::vector<Node>& trees) {
  auto data = std::make_shared<Data>();
  std::vector<Support> supports;
  for (const Node& tree : trees) {
    if (data->bytes.size() > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
    const auto start = data->bytes.size();
    if (!Writer(data->bytes).put(tree)) return std::nullopt;
    // A type may hold more than its fields say, as what was read from a file does.
    if (!(Reader(data->bytes.data() + start).node() == tree)) return std::nullopt;
    data->starts.push_back(static_cast<std::uint32_t>(start));
    supports.push_back(tree::support(tree));
    data->boxes.emplace_back(supports.back().influence);
    data->nodes += tree::count(tree);
  }
  if (!trees.empty()) data->support = Union().support(supports);
  data->bytes.shrink_to_fit();
  data->starts.shrink_to_fit();
  data->boxes.shrink_to_fit();
  PackedTrees packed;
  packed.data_ = std::move(data);
  return packed;
}

std::size_t PackedTrees::size() const { return data_ ? data_->starts.size() : 0; }

Node PackedTrees::tree(std::size_t index) const {
  return Reader(data_->bytes.data() + data_->starts[index]).node();
}

bool PackedTrees::reaches(std::size_t index, const Box& reach) const {
  return tree::reaches(data_->boxes[index].box(), reach);
}

Support PackedTrees::support() const { return data_->support; }

std::size_t PackedTrees::count() const { return data_ ? data_->nodes : 0; }

std::size_t PackedTrees::memory() const {
  if (!data_) return 0;
  return sizeof(Data) + data_->bytes.capacity() +
         data_->starts.capacity() * sizeof(data_->starts[0]) +
         data_->boxes.capacity() * sizeof(data_->boxes[0]);
}

bool operator==(const PackedTrees& a, const PackedTrees& b) {
  if (a.data_ == b.data_) return true;
  return a.size() == b.size() && (a.empty() || a.data_->bytes == b.data_->bytes);
}

}  // namespace hoodoo::tree
