#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "engine/base/json.hpp"
#include "server/http/api.hpp"
#include "server/http/fetch.hpp"
#include "server/http/problem.hpp"
#include "server/http/tokens.hpp"
#include "server/http/turn.hpp"

/// POST /assets: what others have at an address.
namespace hoodoo::http {
namespace {

using nlohmann::json;

constexpr const char* form = "The body must be {\"href\": ADDRESS}, perhaps with an \"id\".";

struct Wanted {
  std::string address;
  std::optional<Digest> digest;
};
/// Errors: bad_input, limit.
Wanted wanted_of(const std::string& text) {
  JsonLimits limits;
  limits.bytes = 16u << 10;
  const auto body = parse_json(text, "", limits);
  if (!body.is_object()) throw Error(Fault::bad_input, "", "must be an object");
  for (const auto& item : body.items()) {
    if (item.key() == "href" || item.key() == "id") continue;
    throw Error(Fault::bad_input, "/" + pointer_token(item.key()), "is neither href nor id");
  }
  const auto text_of = [&body](const char* name) {
    const auto& value = body.at(name);
    if (!value.is_string()) {
      throw Error(Fault::bad_input, std::string("/") + name, "must be a string");
    }
    return value.get<std::string>();
  };
  if (!body.contains("href")) throw Error(Fault::bad_input, "/href", "is missing");
  Wanted wanted{text_of("href"), std::nullopt};
  if (body.contains("id")) {
    wanted.digest = asset::digest_of(text_of("id"));
    if (!wanted.digest) {
      throw Error(Fault::bad_input, "/id", "must be sha256- and 64 lower-case hexadecimal digits");
    }
  }
  target_of(wanted.address, "/href");  // is one that could be asked
  return wanted;
}

}  // namespace

/// Answers when all of it is here, so that nobody has to ask again.
Response Api::fetch_asset(const Request& request, const Parameters&) {
  if (!is_media_type(request.header("content-type"), "application/json")) {
    return problem(415, "Send where the content is as application/json.");
  }
  Wanted wanted;
  try {
    wanted = wanted_of(request.body);
  } catch (const Error& error) {
    return problem(error.fault == Fault::limit ? 413 : 400, form, error.problems);
  }
  std::error_code none;
  if (wanted.digest && assets_.holds(*wanted.digest)) {
    const auto bytes = std::filesystem::file_size(assets_.file(*wanted.digest), none);
    return note_asset(request, *wanted.digest, bytes, 200);
  }
  const Turn turn(fetches_, std::chrono::milliseconds(0));
  if (!turn) {
    auto busy = problem(503, "As much is fetched as may be at once.");
    busy.headers.emplace_back("Retry-After", "5");
    return busy;
  }
  std::optional<asset::Draft> draft;
  std::optional<Response> refused;
  std::uint64_t length = 0;
  const auto begin = [&](std::uint64_t bytes) {
    length = bytes;
    refused = space_refusal(request, length);
    if (refused) throw Error(Fault::limit, "", "no space");
    draft.emplace(assets_, length);
  };
  const auto stopped = [this] { return is_draining(); };
  try {
    fetch(wanted.address, settings_.sources,
          {begin, [&](std::string_view piece) { draft->add(piece); }, stopped});
  } catch (const Error& error) {
    if (refused) return std::move(*refused);
    if (error.fault == Fault::not_found) {
      return problem(502, "Nothing can be had from there.", {{"/href", error.problems.at(0).what}});
    }
    if (error.fault == Fault::limit && length == 0) {
      return problem(422, "That address is not asked.", {{"/href", error.problems.at(0).what}});
    }
    throw;
  }
  // Others of the same key may have come meanwhile.
  if (auto late = space_refusal(request, length)) return std::move(*late);
  return note_asset(request, draft->commit(wanted.digest), length, 201);
}

}  // namespace hoodoo::http
