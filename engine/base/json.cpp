#include "engine/base/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "engine/base/error.hpp"

namespace hoodoo {
namespace {

using nlohmann::json;

/// Builds a document as nlohmann's own handler does, counting on the way.
class BoundedHandler {
 public:
  using number_integer_t = json::number_integer_t;
  using number_unsigned_t = json::number_unsigned_t;
  using number_float_t = json::number_float_t;
  using string_t = json::string_t;
  using binary_t = json::binary_t;

  BoundedHandler(std::string_view text, const std::string& where, const JsonLimits& limits)
      : text_(text), where_(where), limits_(limits) {}

  bool null() { return put(json()); }
  bool boolean(bool v) { return put(json(v)); }
  bool number_integer(number_integer_t v) { return put(json(v)); }
  bool number_unsigned(number_unsigned_t v) { return put(json(v)); }
  bool number_float(number_float_t v, const string_t&) { return put(json(v)); }
  bool string(string_t& v) { return put(json(std::move(v))); }
  bool binary(binary_t&) { return false; }
  bool start_object(std::size_t) { return open(json::object()); }
  bool start_array(std::size_t) { return open(json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(string_t& v) {
    if (stack_.back()->contains(v)) {
      throw Error(Fault::bad_input, where_,
                  fmt::format("has the key \"{}\" twice", v.substr(0, 80)));
    }
    key_ = std::move(v);
    return true;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& e) {
    const auto before = text_.substr(0, std::min(position, text_.size()));
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const auto line_start = before.rfind('\n');
    const auto column = before.size() - (line_start == before.npos ? 0 : line_start + 1);
    if (e.id == 406) throw Error(Fault::bad_input, where_, "holds a number out of range");
    throw Error(Fault::bad_input, where_,
                fmt::format("is not JSON: line {}, column {}", line, column));
  }
  json take() { return std::move(root_); }

 private:
  json* place(json value) {
    if (++count_ > limits_.values) {
      throw Error(Fault::limit, where_, fmt::format("holds more than {} values", limits_.values));
    }
    if (stack_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    json& parent = *stack_.back();
    if (parent.is_object()) return &(parent[key_] = std::move(value));
    parent.push_back(std::move(value));
    return &parent.back();
  }
  bool put(json value) {
    place(std::move(value));
    return true;
  }
  bool open(json value) {
    if (static_cast<int>(stack_.size()) >= limits_.depth) {
      throw Error(Fault::limit, where_, fmt::format("is nested deeper than {}", limits_.depth));
    }
    stack_.push_back(place(std::move(value)));
    return true;
  }
  bool close() {
    stack_.pop_back();
    return true;
  }

  std::string_view text_;
  const std::string& where_;
  const JsonLimits& limits_;
  json root_;
  std::vector<json*> stack_;  // stays valid: a container grows only while it is the innermost
  std::string key_;
  std::size_t count_ = 0;
};

}  // namespace

json parse_json(std::string_view text, const std::string& where, const JsonLimits& limits) {
  if (text.size() > limits.bytes) {
    throw Error(Fault::limit, where,
                fmt::format("is {} bytes long, the limit is {}", text.size(), limits.bytes));
  }
  BoundedHandler handler(text, where, limits);
  if (!json::sax_parse(text, &handler)) throw Error(Fault::bad_input, where, "is not JSON");
  return handler.take();
}

std::string pointer_token(std::string_view key) {
  std::string token;
  for (const char c : key) {
    if (c == '~') {
      token += "~0";
    } else if (c == '/') {
      token += "~1";
    } else {
      token += c;
    }
  }
  return token;
}

}  // namespace hoodoo
