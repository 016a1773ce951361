#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "engine/base/error.hpp"

namespace hoodoo::tileset {

/// Takes a file of JSON apart into the texts of its values, one at a time, without building them:
/// whoever parses a text finds what is wrong inside it.
/// Errors: not_found, io; bad_input naming the file where it ends too early or is no JSON; limit
/// where one value is longer than `most`.
class JsonStream {
 public:
  explicit JsonStream(const std::filesystem::path& file);

  /// The next byte after white space, not taken; nothing at the end.
  std::optional<char> next();
  /// Takes the next byte after white space. It is `c`, or the file is refused.
  void take(char c);
  /// Takes a value as text, or forgets it.
  std::string value(std::size_t most);
  void skip_value();

  std::uint64_t position() const { return start_ + at_; }
  void seek(std::uint64_t position);
  const std::string& where() const { return where_; }

 private:
  bool fill();
  char get();
  template <class Put>
  void pass_value(Put put);
  [[noreturn]] void refuse(const char* why) const;

  std::string where_;
  std::ifstream file_;
  std::string buffer_;
  std::uint64_t start_ = 0;  // of the buffer in the file
  std::size_t at_ = 0;       // in the buffer
};

}  // namespace hoodoo::tileset
