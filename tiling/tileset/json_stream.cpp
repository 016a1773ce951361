#include "tiling/tileset/json_stream.hpp"

#include <fmt/format.h>

namespace hoodoo::tileset {
namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 16;

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

}  // namespace

JsonStream::JsonStream(const std::filesystem::path& file)
    : where_(file.string()), file_(file, std::ios::binary) {
  if (file_) return;
  std::error_code error;
  const bool there = std::filesystem::exists(file, error);
  throw Error(there ? Fault::io : Fault::not_found, where_, "cannot be read");
}

void JsonStream::refuse(const char* why) const {
  throw Error(Fault::bad_input, where_, fmt::format("is not JSON: {} at byte {}", why, position()));
}

bool JsonStream::fill() {
  if (at_ < buffer_.size()) return true;
  start_ += buffer_.size();
  at_ = 0;
  buffer_.resize(buffer_size);
  file_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  buffer_.resize(static_cast<std::size_t>(file_.gcount()));
  if (file_.bad()) throw Error(Fault::io, where_, "cannot be read");
  return !buffer_.empty();
}

char JsonStream::get() {
  if (!fill()) refuse("it ends too early");
  return buffer_[at_++];
}

std::optional<char> JsonStream::next() {
  while (fill()) {
    if (!is_space(buffer_[at_])) return buffer_[at_];
    ++at_;
  }
  return std::nullopt;
}

void JsonStream::take(char c) {
  const auto found = next();
  if (!found) refuse("it ends too early");
  if (*found != c) refuse(fmt::format("'{}' is missing", c).c_str());
  ++at_;
}

template <class Put>
void JsonStream::pass_value(Put put) {
  if (!next()) refuse("it ends too early");
  std::size_t depth = 0;
  bool in_text = false;
  for (;;) {
    const char c = get();
    put(c);
    if (in_text) {
      if (c == '\\') {
        put(get());
      } else if (c == '"') {
        in_text = false;
        if (depth == 0) return;
      }
      continue;
    }
    if (c == '"') in_text = true;
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') {
      if (depth == 0) refuse("a bracket closes nothing");
      if (--depth == 0) return;
    }
    if (depth > 0 || in_text) continue;
    // A number or a word lasts until something else begins.
    const bool ends = !fill() || is_space(buffer_[at_]) || buffer_[at_] == ',' ||
                      buffer_[at_] == '}' || buffer_[at_] == ']' || buffer_[at_] == ':';
    if (ends) return;
  }
}

std::string JsonStream::value(std::size_t most) {
  std::string text;
  pass_value([&](char c) {
    if (text.size() == most) {
      throw Error(Fault::limit, where_,
                  fmt::format("holds a value longer than {} bytes at byte {}", most, position()));
    }
    text += c;
  });
  return text;
}

void JsonStream::skip_value() {
  pass_value([](char) {});
}

void JsonStream::seek(std::uint64_t position) {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(position));
  if (!file_) throw Error(Fault::io, where_, "cannot be read");
  start_ = position;
  buffer_.clear();
  at_ = 0;
}

}  // namespace hoodoo::tileset
