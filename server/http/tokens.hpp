#pragma once
#include <algorithm>
#include <string_view>

/// How values of headers are read: RFC 9110, 5.6.
namespace hoodoo::http {

inline char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Tokens are the same in upper and lower case.
inline bool same_token(std::string_view text, std::string_view token) {
  return std::ranges::equal(text, token, {}, lower, lower);
}

/// Without spaces and tabs around it.
inline std::string_view trimmed(std::string_view text) {
  const auto from = std::min(text.find_first_not_of(" \t"), text.size());
  text.remove_prefix(from);
  return text.substr(0, text.find_last_not_of(" \t") + 1);
}

/// Calls `use` with each part between separators.
template <class Use>
void split(std::string_view text, char separator, const Use& use) {
  for (;;) {
    const auto end = text.find(separator);
    use(text.substr(0, end));
    if (end == text.npos) return;
    text.remove_prefix(end + 1);
  }
}

/// A Content-Type is of `type`, "application/json", whatever its parameters.
inline bool is_media_type(std::string_view header, std::string_view type) {
  return same_token(trimmed(header.substr(0, header.find(';'))), type);
}

}  // namespace hoodoo::http
