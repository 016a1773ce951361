#include <fmt/core.h>

#include <utility>

#include "engine/base/error.hpp"
#include "server/http/api.hpp"
#include "server/http/problem.hpp"
#include "server/http/tokens.hpp"
#include "server/http/tus.hpp"

/// The routes of resumable uploads: tus 1.0.0.
namespace hoodoo::http {
namespace {

Response no_upload() { return problem(404, "There is no such upload."); }
Response is_taken() {
  auto response = problem(423, "The upload is being added to by another request.");
  response.headers.emplace_back("Retry-After", "5");
  return response;
}
Response wrong_offset(std::uint64_t offset) {
  auto response = problem(409, "The upload goes on from another offset.");
  response.headers.emplace_back("Upload-Offset", std::to_string(offset));
  return response;
}

Response is_full(asset::Uploads::Full why) {
  using asset::Uploads;
  auto response =
      why == Uploads::Full::all
          ? problem(503, "Too many uploads are under way.")
          : problem(429, fmt::format("You have {} uploads under way, the most of a key.",
                                     Uploads::most_of_owner));
  response.headers.emplace_back("Retry-After", "60");
  return response;
}

/// Of a client that speaks another protocol. A page of another origin cannot send that header
/// without a preflight, which is refused.
std::optional<Response> other_version(const Request& request) {
  if (request.header("tus-resumable") == tus::version) return std::nullopt;
  auto response = problem(412, "Say Tus-Resumable: 1.0.0.");
  response.headers.emplace_back("Tus-Version", tus::version);
  return response;
}

/// With where the asset is, once there is one.
Response state(const asset::Upload& upload, int status, const std::string& base) {
  Response response;
  response.status = status;
  response.headers = {{"Cache-Control", "no-store"},
                      {"Upload-Offset", std::to_string(upload.offset)},
                      {"Upload-Expires", tus::date(upload.expires)}};
  if (upload.made) {
    response.headers.emplace_back(
        "Link", "<" + base + "/assets/" + asset::name_of(*upload.made) + ">; rel=\"canonical\"");
  }
  return response;
}

/// What one PATCH brings.
struct Part {
  std::uint64_t offset = 0, length = 0;
  std::optional<Digest> checksum;
};

Response add(asset::Uploads::Turn& turn, const Part& part, const std::string& base,
             const ReadBody& read, const std::function<void(const asset::Upload&)>& note) {
  if (turn.offset() != part.offset) return wrong_offset(turn.offset());
  turn.make_room(part.length);
  Sha256 hash;
  const auto received = read([&](std::string_view piece) {
    if (part.checksum) hash.add(piece);
    turn.add(piece);
    return true;
  });
  const bool whole = received == Received::whole;
  // Of a part that was to be checked nothing stays unless it was.
  const bool checked = !part.checksum || (whole && hash.finish() == *part.checksum);
  if (!checked) turn.cut(part.offset);
  const auto upload = turn.end();
  note(upload);
  if (!whole) return not_received(received);
  if (!checked) return problem(460, "The part does not have the checksum that was said.");
  return state(upload, 204, base);
}

}  // namespace

/// The upload of a request, or why it is not to be had.
std::variant<asset::Upload, Response> Api::upload_of(const Request& request,
                                                     std::string_view id) const {
  if (auto refused = other_version(request)) return std::move(*refused);
  auto upload = uploads_.find(id);
  if (!upload) return no_upload();
  if (!request.all_owners && upload->owner != request.owner) {
    return problem(403, "The upload belongs to another key.");
  }
  return std::move(*upload);
}

/// Whose it is, once it is whole.
void Api::note_asset(const asset::Upload& upload) const {
  if (!upload.made) return;
  queue_.add_asset(asset::name_of(*upload.made), upload.owner, upload.length);
}

Response Api::create_upload(const Request& request, const Parameters&) {
  if (auto refused = other_version(request)) return std::move(*refused);
  const auto body = request.header("content-length");
  if ((!body.empty() && body != "0") || !request.header("transfer-encoding").empty()) {
    return problem(400, "An upload is made without content; send it by PATCH.");
  }
  const auto length = tus::number(request.header("upload-length"));
  if (!length) return problem(400, "Upload-Length must say how many bytes will come.");
  std::optional<Digest> wanted;
  try {
    wanted = tus::wanted_digest(request.header("upload-metadata"));
  } catch (const Error& error) {
    return problem(400, "The headers are wrong.", in_headers(error.problems));
  }
  if (auto refused = space_refusal(request, *length)) return std::move(*refused);
  auto created = uploads_.create(*length, wanted, request.owner);
  if (const auto* full = std::get_if<asset::Uploads::Full>(&created)) return is_full(*full);
  auto& upload = std::get<asset::Upload>(created);
  // Others of the same key may have come meanwhile; this one is counted now.
  if (auto refused = space_refusal(request, 0)) {
    uploads_.remove(upload.id);
    return std::move(*refused);
  }
  const auto turn = *length == 0 ? uploads_.take(upload.id) : nullptr;
  if (turn) upload = turn->end();  // there is nothing to wait for
  note_asset(upload);
  auto response = state(upload, 201, settings_.base);
  response.headers.emplace_back("Location", settings_.base + "/uploads/" + upload.id);
  return response;
}

Response Api::upload_state(const Request& request, const Parameters& parameters) {
  auto found = upload_of(request, parameters[0]);
  if (auto* refused = std::get_if<Response>(&found)) return std::move(*refused);
  auto& upload = std::get<asset::Upload>(found);
  if (upload.offset == upload.length && !upload.made) {
    // The server was killed when all had come: what was left to do is done now.
    if (const auto turn = uploads_.take(upload.id)) upload = turn->end();
    note_asset(upload);
  }
  auto response = state(upload, 200, settings_.base);
  response.headers.emplace_back("Upload-Length", std::to_string(upload.length));
  return response;
}

Response Api::add_to_upload(const Request& request, const Parameters& parameters) {
  auto found = upload_of(request, parameters[0]);
  if (auto* refused = std::get_if<Response>(&found)) return std::move(*refused);
  const auto& upload = std::get<asset::Upload>(found);
  if (!is_media_type(request.header("content-type"), tus::content_type)) {
    return problem(415, std::string("Send the part as ") + tus::content_type + ".");
  }
  const auto offset = tus::number(request.header("upload-offset"));
  if (!offset) return problem(400, "Upload-Offset must say where the part belongs.");
  const auto length = tus::number(request.header("content-length"));
  if (!length) return problem(411, "Say how long the body is.");
  Part part{*offset, *length, {}};
  try {
    part.checksum = tus::checksum(request.header("upload-checksum"));
  } catch (const Error& error) {
    return problem(400, "The headers are wrong.", in_headers(error.problems));
  }
  if (part.offset != upload.offset) return wrong_offset(upload.offset);
  if (part.length > upload.length - part.offset) {
    return problem(413, "The part goes beyond the length of the upload.");
  }
  if (upload.made) return state(upload, 204, settings_.base);
  Response response;
  response.take = [this, part, id = upload.id](const ReadBody& read) {
    const auto turn = uploads_.take(id);
    if (!turn) return is_taken();
    return add(*turn, part, settings_.base, read,
               [this](const asset::Upload& made) { note_asset(made); });
  };
  return response;
}

Response Api::remove_upload(const Request& request, const Parameters& parameters) {
  auto found = upload_of(request, parameters[0]);
  if (auto* refused = std::get_if<Response>(&found)) return std::move(*refused);
  if (!uploads_.remove(parameters[0])) return is_taken();
  Response response;
  response.status = 204;
  return response;
}

}  // namespace hoodoo::http
