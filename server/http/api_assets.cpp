#include <nlohmann/json.hpp>

#include "server/http/api.hpp"
#include "server/http/files.hpp"
#include "server/http/problem.hpp"
#include "server/http/tus.hpp"

/// The routes of assets.
namespace hoodoo::http {
namespace {

std::string etag_of(const Digest& digest) { return "\"" + asset::name_of(digest) + "\""; }

}  // namespace

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
    queue_.add_asset(asset::name_of(digest), request.owner, length);
    const auto name = asset::name_of(digest), href = settings_.base + "/assets/" + name;
    auto made = document({{"id", name}, {"href", href}, {"bytes", length}}, 201);
    made.headers.emplace_back("Location", href);
    made.headers.emplace_back("ETag", etag_of(digest));
    return made;
  };
  return response;
}

}  // namespace hoodoo::http
