#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <semaphore>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/asset/uploads.hpp"
#include "server/http/callback_target.hpp"
#include "server/http/encoding.hpp"
#include "server/http/entrance.hpp"
#include "server/http/execution.hpp"
#include "server/http/keys.hpp"
#include "server/http/message.hpp"
#include "server/http/metrics.hpp"
#include "server/http/tilesets.hpp"
#include "server/job/queue.hpp"

/// The routes of the service: a request in, a response out, no socket in sight.
namespace hoodoo::http {

/// Types of problems that OGC API - Processes 1.0 names.
inline constexpr const char* problem_types =
    "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";

/// A document of the service.
Response document(const nlohmann::json& value, int status = 200);

inline constexpr std::size_t most_body = 4u << 20;  // [bytes] of a request
inline constexpr std::size_t most_path = 1024;      // [bytes]

struct ApiSettings {
  std::string base;                          // absolute address of the service, no slash at the end
  std::vector<std::string> hosts;            // Host headers taken; empty: any
  std::filesystem::path viewer;              // folder of the viewer's files
  std::vector<std::string> hidden;           // folders whose names no client sees
  std::vector<std::filesystem::path> roots;  // where inputs by reference lie
  Tilesets tilesets;                         // finished ones
  std::function<nlohmann::json()> scene_schema;
  KeyRing keys;         // empty: everybody may do everything
  AllowList callbacks;  // whom they may go to; empty: there are none
  AllowList sources;    // whom elevations may be fetched from; empty: nobody
  std::function<ConnectionCounts()> connections;  // of the listener; empty: not told
  std::function<bool()> draining;                 // true: takes no jobs any more; empty: never
};

/// Answers every request; never throws. May be called from many threads.
///
///   GET    /  /conformance  /api  /healthz  /readyz  /metrics
///   GET    /processes  /processes/ID                  POST  /processes/ID/execution
///   GET    /jobs  /jobs/ID  /jobs/ID/results  /jobs/ID/results/OUTPUT  /jobs/ID/files/NAME
///   GET    /jobs/ID/events                            DELETE  /jobs/ID
///   GET    /jobs/ID/tiles/...   /tilesets   /tilesets/NAME/...   /viewer/...
///   GET    /assets?id=...  /assets/sha256-HEX         PUT, DELETE  /assets/sha256-HEX
///   POST   /assets
///   POST   /uploads                                   HEAD, PATCH, DELETE  /uploads/ID
///
/// A request that is no execution in form is 400; a scene with problems is 422 with all of them,
/// the pointers into the scene. Documents and tiles of a job, and finished tilesets, may be read by
/// pages of other origins; lists, posting and deleting may not. Documents have an ETag.
///
/// With keys, lists and assets take one with the scope read, posting, sending and deleting submit,
/// /metrics admin (401, 403); a job's own documents and tiles are open to whoever knows its id,
/// which cannot be guessed.
class Api {
 public:
  using Clock = std::chrono::steady_clock;

  Api(job::Queue& queue, asset::Assets& assets, asset::Uploads& uploads, ApiSettings settings);
  Response answer(Request request);
  /// Of an answer to a request that was refused before it came here: gives it what every answer
  /// has, counts it and logs it.
  void note(Request request, Response& response, Clock::time_point since);
  /// The body of such a request is taken piece by piece, by its response.
  static bool takes_body(const Request& head);

 private:
  using Parameters = std::vector<std::string_view>;
  using Handler = Response (Api::*)(const Request&, const Parameters&);
  /// In a pattern, "*" takes one segment and "**" all that follow, as parameters of the handler.
  struct Route {
    std::string_view method, pattern;
    Handler handler;
    std::optional<Scope> needs = std::nullopt;  // of a key, where there are keys
  };
  static const std::vector<Route>& routes();
  Response route(Request& request, std::string_view& pattern);
  std::optional<Response> refusal(const Route& route, Request& request) const;
  Response of_error(const Error& error, const std::string& request_id) const;
  void finish(const Request& request, Response& response);
  std::optional<Response> refusal_of_condition(const Request& request);
  void conclude(const Request& request, std::string_view pattern, Clock::time_point since,
                Response& response);

  Response landing(const Request&, const Parameters&);
  Response api_document(const Request&, const Parameters&);
  Response conforms(const Request&, const Parameters&);
  Response processes(const Request&, const Parameters&);
  Response process(const Request&, const Parameters&);
  Response execute(const Request&, const Parameters&);
  Response jobs(const Request&, const Parameters&);
  Response status(const Request&, const Parameters&);
  Response dismiss(const Request&, const Parameters&);
  Response job_results(const Request&, const Parameters&);
  Response one_result(const Request&, const Parameters&);
  Response events(const Request&, const Parameters&);
  Response result_file(const Request&, const Parameters&);
  Response tile(const Request&, const Parameters&);
  Response tilesets(const Request&, const Parameters&);
  Response tileset_file(const Request&, const Parameters&);
  Response viewer(const Request&, const Parameters&);
  Response viewer_folder(const Request&, const Parameters&);
  Response asset_list(const Request&, const Parameters&);
  Response asset(const Request&, const Parameters&);
  Response put_asset(const Request&, const Parameters&);
  Response fetch_asset(const Request&, const Parameters&);
  Response remove_asset(const Request&, const Parameters&);
  Response create_upload(const Request&, const Parameters&);
  Response upload_state(const Request&, const Parameters&);
  Response add_to_upload(const Request&, const Parameters&);
  Response remove_upload(const Request&, const Parameters&);
  Response health(const Request&, const Parameters&);
  Response ready(const Request&, const Parameters&);
  Response metrics(const Request&, const Parameters&);
  bool is_draining() const { return settings_.draining && settings_.draining(); }

  Response submit(const job::Request& wanted);
  Response answer_to(const job::Submitted& submitted) const;
  job::Quota quota_of(const Request& request) const;
  std::optional<Response> space_refusal(const Request& request, std::uint64_t bytes) const;
  void note_asset(const asset::Upload& upload) const;
  Response note_asset(const Request& request, const Digest& digest, std::uint64_t bytes,
                      int status) const;
  std::optional<Response> callback_refusal(const job::Subscriber& subscriber, bool async) const;
  Response validate(const job::Request& wanted, bool raw);
  References references(const Request& request) const;
  std::variant<asset::Upload, Response> upload_of(const Request& request,
                                                  std::string_view id) const;
  nlohmann::json info(const job::Job& job) const;
  nlohmann::json results_of(job::Job job) const;
  std::vector<Problem> visible(const job::Job& job) const;
  Response unfinished(const job::Job& job) const;
  Response archive(const job::Job& job);

  job::Queue& queue_;
  asset::Assets& assets_;
  asset::Uploads& uploads_;
  const ApiSettings settings_;
  Metrics metrics_;
  Encoder encoder_;
  std::timed_mutex large_;                 // held by the one large body that is taken apart
  std::counting_semaphore<> archives_{8};  // sent at once
  std::counting_semaphore<> checks_{4};    // scenes that processes look at, at once
  std::counting_semaphore<> fetches_{4};   // contents that are fetched at once
};

}  // namespace hoodoo::http
