#include "server/http/problem.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <system_error>

#include "server/asset/assets.hpp"

namespace hoodoo::http {
namespace {

std::string_view title_of(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 409:
      return "Conflict";
    case 411:
      return "Length Required";
    case 412:
      return "Precondition Failed";
    case 413:
      return "Content Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 416:
      return "Range Not Satisfiable";
    case 421:
      return "Misdirected Request";
    case 422:
      return "Unprocessable Content";
    case 423:
      return "Locked";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 460:
      return "Checksum Mismatch";
    case 501:
      return "Not Implemented";
    case 502:
      return "Bad Gateway";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    case 507:
      return "Insufficient Storage";
    default:
      return "Internal Server Error";
  }
}

/// A place as `in_query` or `header_place` gave it, or else a pointer.
nlohmann::json to_json(const Problem& found) {
  nlohmann::json error{{"detail", found.what}};
  const std::string_view where = found.where;
  if (where.starts_with('?')) {
    if (where.size() > 1) error["parameter"] = where.substr(1);
  } else if (where.ends_with(':') && !where.starts_with('/')) {
    error["header"] = where.substr(0, where.size() - 1);
  } else {
    error["pointer"] = where;
  }
  return error;
}

/// In the system's words, this program's or the database's.
bool tells_of_space(const Problem& found) {
  const auto& category = std::generic_category();
  for (const auto& words : {category.message(ENOSPC), category.message(EDQUOT),
                            std::string(asset::no_space), std::string("disk is full")}) {
    if (found.what.find(words) != found.what.npos) return true;
  }
  return false;
}

void hide(std::string& text, const std::string& folder) {
  if (folder.empty()) return;
  for (auto at = text.find(folder); at != text.npos; at = text.find(folder, at)) {
    text.erase(at, folder.size());
  }
}

}  // namespace

int status_of(Fault fault, const std::vector<Problem>& problems) {
  switch (fault) {
    case Fault::bad_input:
      return 422;
    case Fault::not_found:
      return 404;
    case Fault::limit:
      return 413;
    case Fault::cancelled:
      return 409;
    case Fault::io:
      return std::ranges::any_of(problems, tells_of_space) ? 507 : 500;
    case Fault::internal:
      return 500;
  }
  return 500;
}

Response problem(int status, const std::string& detail, const std::vector<Problem>& problems,
                 const std::string& type) {
  nlohmann::json body{
      {"type", type}, {"title", title_of(status)}, {"status", status}, {"detail", detail}};
  for (const auto& found : problems) body["errors"].push_back(to_json(found));
  Response response;
  response.status = status;
  response.type = "application/problem+json";
  response.headers = {{"Cache-Control", "no-store"}};
  response.body = body.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  return response;
}

std::vector<Problem> in_query(std::vector<Problem> problems) {
  for (auto& found : problems) found.where = "?" + found.where;
  return problems;
}
std::vector<Problem> in_headers(std::vector<Problem> problems) {
  for (auto& found : problems) found.where = header_place(found.where);
  return problems;
}
std::string header_place(const std::string& name) { return name + ":"; }

Response over_quota(std::uint64_t used, std::uint64_t wanted, std::uint64_t most) {
  auto what = fmt::format("{} bytes are used, the limit of the key is {} bytes", used, most);
  if (wanted > 0) what = fmt::format("{} more bytes are wanted; ", wanted) + what;
  if (wanted > most) {
    return problem(413, "It is larger than all that this key may keep.", {{"", what}});
  }
  return problem(403, "The key has no space left; delete jobs or assets.", {{"", what}});
}

Response not_received(Received how) {
  switch (how) {
    case Received::slow:
      return problem(408, "The body came too slowly.");
    case Received::stopped:
      return problem(503, "The server is about to stop.");
    case Received::refused:
      return problem(413, "The body is over the limit.");
    default:
      return problem(400, "The body did not come whole.");
  }
}

std::vector<Problem> shown(Fault fault, std::vector<Problem> problems,
                           const std::vector<std::string>& hidden) {
  if (fault == Fault::internal) return {{"", "internal error"}};
  for (auto& found : problems) {
    for (const auto& folder : hidden) {
      hide(found.where, folder);
      hide(found.what, folder);
    }
  }
  return problems;
}

}  // namespace hoodoo::http
