#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
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
/// If-None-Match is answered 304, a single byte range 206 (with If-Range), several ranges and one
/// that is not inside 416; a Range of something else is ignored. A file named by its SHA-256 never
/// changes and may be kept for ever; any other is asked for again.
///
/// Everything else answers 404, but 503 a file that is there and cannot be read now.
Response serve_file(const Folder& folder, std::string_view name, const Request& request);

/// The same of a part of an open file, that `name` stands for: one in an archive.
Response serve_part(const FilePart& part, std::string_view name, const Request& request);

/// `name` is of such segments, and has one of these endings.
bool may_be_served(std::string_view name, std::span<const std::string_view> extensions);
/// Content type of a file by its ending.
std::string type_of(std::string_view extension);
enum class Comparison : std::uint8_t { weak, strong };
/// A header of If-None-Match, or with the strong comparison of If-Match, lists the tag: RFC
/// 9110, 8.8.3.2.
bool lists(std::string_view header, std::string_view etag,
           Comparison comparison = Comparison::weak);
/// `name` is one such segment.
bool is_plain_name(std::string_view name);

}  // namespace hoodoo::http
