#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.hpp"

/// Files below a folder, as a static file server gives them.
namespace hoodoo::http {

/// One folder that is served.
struct Folder {
  std::filesystem::path path;
  std::vector<std::string_view> extensions;  // with the dot; nothing else is served
};

/// Answers GET and HEAD of `name`, relative to the folder and decoded.
///
/// A name is segments of letters, digits, '.', '_' and '-', none starting with a dot; no symbolic
/// link is followed, inside or out; a folder is not listed. Each file has a strong ETag;
/// If-None-Match is answered 304, a single byte range 206 (with If-Range), several ranges 416. A
/// file named by its SHA-256 never changes and may be kept for ever; any other is asked for again.
///
/// Everything else answers 404.
Response serve_file(const Folder& folder, std::string_view name, const Request& request);

}  // namespace hoodoo::http
