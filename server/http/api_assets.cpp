#include <fmt/core.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "server/http/api.hpp"
#include "server/http/files.hpp"
#include "server/http/problem.hpp"
#include "server/http/query.hpp"
#include "server/http/tus.hpp"

/// The routes of assets.
namespace hoodoo::http {
namespace {

using nlohmann::json;

constexpr int most_asked = 100;

std::string etag_of(const Digest& digest) { return "\"" + asset::name_of(digest) + "\""; }

json about_asset(const Digest& digest, std::uint64_t bytes, const std::string& base) {
  const auto name = asset::name_of(digest);
  return {{"id", name}, {"href", base + "/assets/" + name}, {"bytes", bytes}};
}

/// The names of a query "id=A,B". Errors: bad_input.
std::vector<Digest> digests_of(std::string_view text) {
  const auto query = parse_query(text);
  const auto ids = query.find("id");
  if (query.size() != 1 || ids == query.end()) {
    throw Error(Fault::bad_input, "id", "must name assets, and is the only parameter");
  }
  std::vector<Digest> digests;
  for (std::string_view rest = ids->second;;) {
    const auto comma = rest.find(',');
    const auto name = rest.substr(0, comma);
    const auto digest = asset::digest_of(name);
    if (!digest || digests.size() == most_asked) {
      throw Error(Fault::bad_input, "id",
                  fmt::format("must be 1 to {} names, sha256- and 64 lower-case hexadecimal "
                              "digits, with commas between",
                              most_asked));
    }
    digests.push_back(*digest);
    if (comma == rest.npos) return digests;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace

/// Which of some assets are here, so that a client need not provoke a 404 to learn it.
Response Api::asset_list(const Request& request, const Parameters&) {
  std::vector<Digest> wanted;
  try {
    wanted = digests_of(request.query);
  } catch (const Error& error) {
    return problem(400, "The parameters are wrong.", in_query(error.problems));
  }
  json found = json::array();
  for (const auto& digest : wanted) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(assets_.file(digest), error);
    if (!error) found.push_back(about_asset(digest, bytes, settings_.base));
  }
  return document({{"assets", found}});
}

Response Api::asset(const Request& request, const Parameters& parameters) {
  const auto digest = asset::digest_of(parameters[0]);
  if (!digest) return problem(404, "There is no such asset.");
  auto response = serve_file({assets_.file(*digest).parent_path(), {""}}, parameters[0], request);
  for (auto& [name, value] : response.headers) {
    // What takes a key is not for the caches of others.
    const bool is_public = name == "Cache-Control" && value.starts_with("public");
    if (is_public && !settings_.keys.empty()) value.replace(0, 6, "private");
  }
  response.headers.emplace_back("Content-Disposition", "attachment");
  return response;
}

/// What tells of an asset that has just come, or was asked for again.
Response Api::note_asset(const Request& request, const Digest& digest, std::uint64_t bytes,
                         int status) const {
  const auto info = about_asset(digest, bytes, settings_.base);
  if (status == 201) queue_.add_asset(asset::name_of(digest), request.owner, bytes);
  auto made = document(info, status);
  made.headers.emplace_back("Location", info.at("href").get<std::string>());
  made.headers.emplace_back("ETag", etag_of(digest));
  return made;
}

/// Why a key may not send so much. What it sends by other uploads counts from their beginning.
std::optional<Response> Api::space_refusal(const Request& request, std::uint64_t bytes) const {
  const auto most = quota_of(request).bytes;
  if (!most) return std::nullopt;
  const auto used = queue_.bytes_of(request.owner) + uploads_.under_way(request.owner);
  if (bytes <= *most && used <= *most - bytes) return std::nullopt;
  return over_quota(used, bytes, *most);
}

/// A job that waits is sure of its elevations.
Response Api::remove_asset(const Request& request, const Parameters& parameters) {
  const auto digest = asset::digest_of(parameters[0]);
  if (!digest || !assets_.holds(*digest)) return problem(404, "There is no such asset.");
  if (!request.all_owners && queue_.owner_of(parameters[0]) != request.owner) {
    return problem(403, "The asset was sent with another key.");
  }
  if (!queue_.release(parameters[0], std::nullopt, [&] { assets_.remove(*digest); })) {
    return problem(409, "A job that waits or runs needs the asset.");
  }
  Response response;
  response.status = 204;
  return response;
}

Response Api::put_asset(const Request& request, const Parameters& parameters) {
  const auto digest = asset::digest_of(parameters[0]);
  if (!digest) {
    return problem(400, "An asset is named sha256- and 64 lower-case hexadecimal digits.");
  }
  if (!request.header("content-range").empty()) {
    return problem(400, "An asset is put whole; parts go to /uploads.");
  }
  const auto length = tus::number(request.header("content-length"));
  if (!length) return problem(411, "Say how long the body is.");
  if (assets_.holds(*digest)) {
    Response had;
    had.status = 204;
    had.headers = {{"ETag", etag_of(*digest)}};
    if (*length > assets_.most() || !request.header("expect").empty()) return had;
    // Who has not asked sends it without listening.
    Response response;
    response.take = [had](const ReadBody& read) {
      const auto received = read([](std::string_view) { return true; });
      return received == Received::whole ? had : not_received(received);
    };
    return response;
  }
  if (auto refused = space_refusal(request, *length)) return std::move(*refused);
  assets_.reserve(*length);  // is refused now, if ever, before it is sent
  Response response;
  response.take = [this, digest = *digest, length = *length, request](const ReadBody& read) {
    asset::Draft draft(assets_, length);
    const auto received = read([&draft](std::string_view piece) {
      draft.add(piece);
      return true;
    });
    if (received != Received::whole) return not_received(received);
    // Others of the same key may have come meanwhile.
    if (auto refused = space_refusal(request, length)) return std::move(*refused);
    draft.commit(digest);
    return note_asset(request, digest, length, 201);
  };
  return response;
}

}  // namespace hoodoo::http
